//! Promise: a file whose hashes were made right again is still refused when it breaks a rule,
//! by the rule's own name, without a panic and without a hang.

mod sample;

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use fct::{Child, F32, Loops, NormalRecord, Rule, ShortFloat, Tree, pack};
use sample::{Sample, Split, rehash, rehash_header, section};

/// A way to break a file.
enum Break {
    /// Before writing: all hashes come out right.
    Data(fn(&mut Sample)),
    /// Before packing.
    Plain(fn(&mut Sample)),
    /// After writing: hashes are made right again.
    Bytes(fn(&mut Vec<u8>)),
    /// After writing, and header and table hash made right again, the others not.
    Header(fn(&mut Vec<u8>)),
    /// After writing, and nothing made right.
    Raw(fn(&mut Vec<u8>)),
}
use Break::{Bytes, Data, Header, Plain, Raw};

impl Break {
    fn apply(&self, sample: &Sample) -> Vec<u8> {
        let mut sample = sample.clone();
        if let Plain(edit) = self {
            edit(&mut sample);
            sample.pack();
        }
        if let Data(edit) = self {
            edit(&mut sample);
        }
        let mut bytes = sample.bytes();
        match self {
            Data(_) | Plain(_) => {}
            Bytes(edit) => {
                edit(&mut bytes);
                rehash(&mut bytes);
            }
            Header(edit) => {
                edit(&mut bytes);
                rehash_header(&mut bytes);
            }
            Raw(edit) => edit(&mut bytes),
        }
        bytes
    }
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// Gives a sample chunks, to be broken.
fn in_chunks(sample: &mut Sample) -> &mut fct::ChunkData {
    *sample = sample.clone().in_chunks(30);
    sample.chunks.as_mut().unwrap()
}

/// Edits the entry of a section in the table at an offset within the entry.
fn put_entry(bytes: &mut [u8], tag: &[u8; 4], at: usize, value: &[u8]) {
    let (entry, _, _) = section(bytes, tag);
    put(bytes, entry + at, value);
}

const NAN: f32 = f32::NAN;

const SHORT_NAN: ShortFloat = ShortFloat::from_bits(0x7FC0);

fn short(x: f64) -> ShortFloat {
    ShortFloat::up(x)
}

/// Set in a child of a top node that is a page.
const PAGE: u32 = 1 << 31;

/// Each rule of the format with ways to break it.
const BREAKS: &[(Rule, &[Break])] = &[
    (Rule::Signature, &[Raw(|b| b[0] = 0), Bytes(|b| b[7] = 0)]),
    (Rule::TooShort, &[Raw(|b| b.truncate(127))]),
    (Rule::ByteOrder, &[Bytes(|b| b[12] = 0)]),
    (Rule::Version, &[Bytes(|b| b[8] = 2), Bytes(|b| b[8] = 0)]),
    (Rule::FileLength, &[Bytes(|b| b[16] ^= 1), Bytes(|b| put(b, 16, &[0xFF; 8]))]),
    (Rule::Features, &[Bytes(|b| b[31] = 0x80)]),
    (Rule::HeaderHash, &[Raw(|b| b[96] ^= 1), Raw(|b| b[120] ^= 1)]),
    (
        Rule::ReservedZero,
        &[
            Bytes(|b| b[116] = 1),
            Bytes(|b| put_entry(b, b"NODE", 4, &[3])),
            Bytes(|b| put_entry(b, b"NODE", 30, &[1])),
            Bytes(|b| put_entry(b, b"NODE", 63, &[1])),
            Data(|s| s.packed.pages[1].reserved = 1),
        ],
    ),
    (
        Rule::SectionCount,
        &[Raw(|b| put(b, 40, &[0; 4])), Raw(|b| put(b, 40, &[65, 0, 0, 0])), Raw(|b| put(b, 40, &[0xFF; 4]))],
    ),
    (
        Rule::TablePlace,
        &[
            Bytes(|b| b[44] = 32),
            Bytes(|b| b[44] = 65),
            Raw(|b| put(b, 44, &[0xF8, 0xFF, 0xFF, 0xFF])),
            Bytes(|b| b[48] = 64),
        ],
    ),
    (
        Rule::SectionPlace,
        &[
            Header(|b| put_entry(b, b"NODE", 8, &[0xFF; 8])),
            Header(|b| put_entry(b, b"NODE", 9, &[0])),
            Header(|b| put_entry(b, b"NODE", 28, &[5])),
            Header(|b| put_entry(b, b"NODE", 28, &[63])),
            Header(|b| put_entry(b, b"NODE", 28, &[200])),
            // An overlap: vertices where the nodes are.
            Header(|b| {
                let (_, start, _) = section(b, b"NODE");
                put_entry(b, b"VERT", 8, &(start as u64).to_le_bytes());
            }),
            // A length that wraps, of a section that agrees with itself.
            Header(|b| {
                let count = u64::MAX - 4096;
                put_entry(b, b"LOOP", 16, &count.to_le_bytes());
                put_entry(b, b"LOOP", 32, &count.to_le_bytes());
            }),
            // A hole at the end of the file.
            Header(|b| {
                b.extend([0; 64]);
                let len = b.len() as u64;
                put(b, 16, &len.to_le_bytes());
            }),
        ],
    ),
    (
        Rule::SectionSize,
        &[
            Header(|b| put_entry(b, b"NODE", 24, &[65])),
            Header(|b| put_entry(b, b"NODE", 24, &[0])),
            Header(|b| put_entry(b, b"NODE", 32, &[1])),
            // 2^58 nodes of 64 bytes: the product wraps to 0.
            Header(|b| {
                put_entry(b, b"TOPN", 16, &[0; 8]);
                put_entry(b, b"TOPN", 32, &(1_u64 << 58).to_le_bytes());
            }),
        ],
    ),
    (
        Rule::SectionTag,
        &[Header(|b| {
            put_entry(b, b"LINK", 4, &[0]);
            put_entry(b, b"LINK", 0, b"COLR");
        })],
    ),
    (
        Rule::SectionRequired,
        &[
            Header(|b| {
                put_entry(b, b"LOOP", 4, &[0]);
                put_entry(b, b"LOOP", 0, b"Loop");
            }),
            Header(|b| {
                put_entry(b, b"META", 4, &[0]);
                put_entry(b, b"META", 0, b"Meta");
            }),
        ],
    ),
    (Rule::SectionKnown, &[Header(|b| put_entry(b, b"LOOP", 0, b"Loop"))]),
    (Rule::HashKind, &[Header(|b| put_entry(b, b"LOOP", 29, &[2]))]),
    (
        Rule::Counts,
        &[
            // A billion nodes in a few KiB.
            Bytes(|b| put(b, 56, &1_000_000_000_u64.to_le_bytes())),
            Bytes(|b| b[64] ^= 1),
            Bytes(|b| b[72] ^= 1),
        ],
    ),
    (
        Rule::RootPlace,
        &[Bytes(|b| put(b, 112, &1_u32.to_le_bytes())), Bytes(|b| put(b, 112, &(1_u32 << 31).to_le_bytes()))],
    ),
    (
        Rule::MetaReadable,
        &[Bytes(|b| {
            let (_, start, _) = section(b, b"META");
            // 253 introduces a 64-bit length, here of the first string.
            put(b, start, &[253, 0, 0, 0, 0, 0, 0, 0, 0x40]);
        })],
    ),
    (
        Rule::SectionHash,
        &[
            Raw(|b| {
                let (_, start, _) = section(b, b"NODE");
                b[start] ^= 1;
            }),
            Header(|b| put_entry(b, b"COLR", 40, &[1, 2, 3])),
        ],
    ),
    (Rule::ContentId, &[Header(|b| b[80] ^= 1)]),
    (
        Rule::PaddingZero,
        &[Bytes(|b| {
            let (_, start, _) = section(b, b"NODE");
            b[start - 1] = 1;
        })],
    ),
    (
        Rule::ChildPlace,
        &[
            // A cycle, a shared child, out of range, kinds exchanged, and a page that is too small.
            Data(|s| s.packed.tops[0].left = 0.into()),
            Data(|s| s.packed.tops[0].left = 2.into()),
            Data(|s| s.packed.tops[0].right = 0x7FFF_FFFF.into()),
            Data(|s| s.packed.tops[0].right = u32::MAX.into()),
            Data(|s| s.packed.tops[1].left = (PAGE | 1).into()),
            Data(|s| s.packed.tops[1].left = 2.into()),
            Data(|s| s.packed.tops[0].left = PAGE.into()),
            // Two nodes exchanged, and their parent told.
            Data(|s| {
                s.packed.tops.swap(1, 2);
                s.packed.tops[0].left = 2.into();
                s.packed.tops[0].right = 1.into();
            }),
        ],
    ),
    (
        Rule::FaceRange,
        &[
            Data(|s| s.packed.nodes[0].left_faces = 0),
            Data(|s| s.packed.nodes[0].left_faces = 24),
            Data(|s| s.packed.nodes[3].left_faces = 0x80),
            Data(|s| s.packed.nodes[3].left_faces = 0x7F),
            Data(|s| s.packed.tops[0].right = s.packed.tops[0].left),
            Data(|s| s.packed.tops[1].right = (PAGE | 3).into()),
            Data(|s| s.packed.tops[2].first_face = u32::MAX.into()),
        ],
    ),
    (Rule::Depth, &[Data(|s| *s = Sample::fan(200, Split::OneByOne))]),
    (
        Rule::VertexIndex,
        &[
            Data(|s| s.packed.faces[7].vertices[2] = 255),
            Data(|s| s.packed.loops[3] = 255),
            Data(|s| s.packed.top_loops[1] = 0x7E),
            Data(|s| s.weld[0].representative = u32::MAX.into()),
        ],
    ),
    (
        Rule::VertexOrder,
        &[Data(|s| s.packed.faces[0].vertices.rotate_left(1)), Data(|s| s.packed.faces.swap(0, 1))],
    ),
    (
        Rule::LoopRange,
        &[
            Data(|s| s.packed.tops[1].loop_start = u32::MAX.into()),
            Data(|s| s.packed.tops[2].loop_end = u32::MAX.into()),
            Data(|s| {
                let last = s.packed.top_loops.len() - 1;
                s.packed.top_loops[last] = 0xFF;
            }),
            // A loop of nothing after another one.
            Data(|s| s.packed.loops[2] = 0),
        ],
    ),
    (
        Rule::LoopCover,
        &[
            Data(|s| s.packed.loops.push(0)),
            Data(|s| {
                s.packed.loops.push(0);
                let last = s.packed.pages.last_mut().unwrap();
                last.loop_bytes = (last.loop_bytes.get() + 1).into();
            }),
            // The way to the right child is wrong.
            Data(|s| s.packed.loops[0] ^= 1),
            Data(|s| s.packed.tops[2].loop_start = 0.into()),
            Data(|s| s.packed.top_loops.push(0)),
            // A small node whose parent says that there are no loops below.
            Data(|s| {
                *s = Sample::fan(4, Split::Halves);
                s.packed.nodes[1].left_faces |= 0x80;
            }),
        ],
    ),
    (
        Rule::LoopBoundary,
        &[
            Data(|s| s.packed.loops.swap(3, 4)),
            // A node that is drawn without its loops, in a page and above.
            Plain(|s| s.plain.boundaries[3].clear()),
            Plain(|s| s.plain.boundaries[1].clear()),
            // The other way round.
            Plain(|s| {
                let rim = &mut s.plain.boundaries[1];
                let last = rim.len() - 1;
                rim[last] &= !fct::LOOP_END;
                rim.reverse();
                rim[last] |= fct::LOOP_END;
            }),
            // Two faces that touch in a vertex: their loops are not to be told from the faces.
            Data(|s| {
                *s = Sample::fan(4, Split::Halves);
                let [a, b, c] = [[0, 1, 2], [0, 3, 4], [0, 2, 3]];
                s.plain.faces[..3].copy_from_slice(&[a, b, c]);
                s.plain.boundaries[1] = vec![0, 1, 2 | fct::LOOP_END, 0, 3, 4 | fct::LOOP_END];
                s.pack();
                assert!(!s.packed.loops.is_empty(), "a packer stores such loops");
                s.packed.loops.clear();
                s.packed.pages[0].loop_bytes = 0.into();
                for node in &mut s.packed.nodes {
                    node.left_faces &= 0x7F;
                }
            }),
        ],
    ),
    (
        Rule::WeldOrder,
        &[
            Data(|s| s.weld.reverse()),
            Data(|s| s.weld[1] = s.weld[0]),
            Data(|s| s.weld[0].representative = s.weld[0].vertex),
            Data(|s| s.weld[0].representative = s.weld[1].vertex),
        ],
    ),
    (
        Rule::WeldEqual,
        &[
            Data(|s| s.weld[0].representative = 0.into()),
            Data(|s| {
                let copy = s.weld[2].vertex.get() as usize;
                s.vertices[copy].budget = short(3.0);
            }),
        ],
    ),
    (
        Rule::PolygonOrder,
        &[
            Data(|s| s.bounding_polygons.swap(0, 1)),
            Data(|s| s.bounding_polygons[1] = s.bounding_polygons[0]),
            Data(|s| s.bounding_polygons[2].node = u32::MAX.into()),
        ],
    ),
    (
        Rule::GroupRange,
        &[
            Data(|s| s.groups.swap(0, 1)),
            Data(|s| s.groups[1] = s.groups[0]),
            Data(|s| s.groups[0].name = 2.into()),
            Data(|s| s.groups[0].face_count = 1.into()),
            Data(|s| s.groups[1].first_face = 0.into()),
            Data(|s| s.groups[1].root = u32::MAX.into()),
            // Nested: the whole and a part of it.
            Data(|s| {
                s.groups[0].root = 0.into();
                s.groups[0].face_count = 96.into();
            }),
        ],
    ),
    (
        Rule::MetaAgrees,
        &[
            Data(|s| s.meta.faces_in += 1),
            Data(|s| s.meta.faces_kept -= 1),
            Data(|s| s.meta.dropped = vec![(String::new(), u64::MAX); 2]),
            Data(|s| s.meta.depth += 1),
            Data(|s| s.meta.bounds_max[2] *= 2.0),
            Data(|s| s.meta.bounds_min[0] = NAN),
            Data(|s| {
                *s = Sample::fan(5, Split::Halves);
                s.meta.closed = true;
            }),
        ],
    ),
    (
        Rule::PageRange,
        &[
            Data(|s| s.packed.pages[1].first_face = 0.into()),
            Data(|s| s.packed.pages[2].first_vertex = u32::MAX.into()),
            Data(|s| s.packed.pages[1].first_link = 1.into()),
            Data(|s| s.packed.pages[3].first_loop = 0.into()),
            Data(|s| s.packed.pages[1].faces = 0),
            Data(|s| s.packed.pages[1].faces = 254),
            Data(|s| s.packed.pages[1].own_vertices = 300.into()),
            Data(|s| s.packed.pages[3].links = 200.into()),
            Data(|s| {
                let last = s.vertices[0];
                s.vertices.push(last);
                s.normals = None;
                s.colors = None;
            }),
        ],
    ),
    (
        Rule::LinkOrder,
        &[
            Data(|s| s.packed.links.swap(0, 1)),
            Data(|s| s.packed.links[1] = s.packed.links[0]),
            Data(|s| *s.packed.links.last_mut().unwrap() = u32::MAX.into()),
            // A link that no face uses.
            Data(|s| {
                let last = s.packed.pages.last().unwrap();
                let link = (last.own_vertices.get() + last.links.get() - 1) as u8;
                let first = last.first_face.get() as usize;
                let corners = s.packed.faces[first..].iter_mut().flat_map(|f| &mut f.vertices);
                corners.filter(|v| **v == link).for_each(|v| *v = 0);
            }),
        ],
    ),
    (
        Rule::Chunk,
        &[
            Data(|s| in_chunks(s).crown[40] ^= 1),
            Data(|s| *in_chunks(s).crown.last_mut().unwrap() ^= 1),
            Data(|s| in_chunks(s).crown.push(0)),
            Data(|s| in_chunks(s).crown.clear()),
            Data(|s| in_chunks(s).tops[5] ^= 1),
            Data(|s| in_chunks(s).tops.push(0)),
            Data(|s| in_chunks(s).tops.truncate(20)),
            // Of another size than the head says.
            Data(|s| in_chunks(s).crown[0] ^= 32),
        ],
    ),
    (
        Rule::Finite,
        &[
            Data(|s| s.packed.tops[1].center[1] = NAN.into()),
            Data(|s| s.packed.tops[1].radius = f32::INFINITY.into()),
            Data(|s| s.packed.tops[1].bound = NAN.into()),
            Data(|s| s.packed.tops[1].budget = NAN.into()),
            Data(|s| s.packed.tops[1].epsilon = f32::INFINITY.into()),
            Data(|s| s.packed.nodes[3].bound = SHORT_NAN),
            Data(|s| s.packed.nodes[3].budget = SHORT_NAN),
            Data(|s| s.vertices[3].position[0] = f32::NEG_INFINITY.into()),
            Data(|s| s.vertices[3].radius = SHORT_NAN),
            Data(|s| s.vertices[3].radius = ShortFloat::INFINITY),
            Data(|s| s.vertices[3].bound = SHORT_NAN),
            Data(|s| s.bounding_polygons[0].support[7] = SHORT_NAN),
            Data(|s| s.bounding_polygons[0].low = short(100.0)),
        ],
    ),
    (
        Rule::NotNegative,
        &[
            Data(|s| s.packed.tops[1].radius = (-1.0).into()),
            Data(|s| s.packed.tops[1].bound = (-1.0).into()),
            Data(|s| s.packed.tops[1].budget = f32::NEG_INFINITY.into()),
            Data(|s| s.packed.tops[1].epsilon = (-1e-30).into()),
            Data(|s| s.packed.nodes[3].bound = short(-1.0)),
            Data(|s| s.packed.nodes[3].budget = short(-1e-30)),
            Data(|s| s.vertices[0].radius = short(-1.0)),
            Data(|s| s.vertices[0].budget = short(-1.0)),
        ],
    ),
    (
        Rule::UnitVector,
        &[
            Data(|s| s.packed.tops[1].axis = pack([0.0; 3])),
            Data(|s| s.packed.tops[1].axis = pack([NAN, 0.0, 1.0])),
            Data(|s| s.packed.tops[1].axis = pack([0.0, 0.0, 1.001])),
        ],
    ),
    (
        Rule::Cosine,
        &[Data(|s| s.packed.tops[1].cos = 1.0001.into()), Data(|s| s.packed.tops[1].cos = NAN.into())],
    ),
    (
        Rule::KeyOrder,
        &[
            Data(|s| s.packed.nodes[3].bound = ShortFloat::INFINITY),
            Data(|s| s.packed.nodes[3].budget = short(1e9)),
            Data(|s| s.packed.tops[1].bound = 20.0.into()),
        ],
    ),
    (
        Rule::Grid,
        &[
            Data(|s| s.packed.pages[0].quantum = 0.0.into()),
            Data(|s| s.packed.pages[0].quantum = NAN.into()),
            Data(|s| s.packed.pages[1].quantum = (-0.5).into()),
            Data(|s| s.packed.pages[1].quantum = f32::INFINITY.into()),
            Data(|s| s.packed.pages[1].quantum = 0.75.into()),
            Data(|s| s.packed.pages[0].origin[2] = NAN.into()),
            Data(|s| s.packed.pages[0].origin[0] = f32::MAX.into()),
            // Half a step off.
            Data(|s| {
                let page = &mut s.packed.pages[0];
                page.origin[1] = (page.origin[1].get() + 0.5 * page.quantum.get()).into();
            }),
        ],
    ),
    (
        Rule::SphereNested,
        &[
            Data(|s| s.packed.nodes[3].radius = 255),
            Data(|s| s.packed.nodes[3].center[0] ^= 0x40),
            Data(|s| {
                // A single step too little.
                let radius = s.packed.tops[1].radius.get();
                s.packed.tops[1].radius = F32::new(radius * 0.999);
            }),
        ],
    ),
    (
        Rule::SphereHolds,
        &[Data(|s| {
            let last = s.packed.nodes.len() - 1;
            s.packed.nodes[last].radius = 1;
        })],
    ),
    (
        Rule::ConeHolds,
        &[
            Data(|s| s.packed.nodes[30].axis = NormalRecord::encode([0.0, 0.0, -1.0])),
            Data(|s| s.packed.nodes[0].width = 0),
            Data(|s| s.packed.tops[1].cos = 1.0.into()),
        ],
    ),
    (
        Rule::PolygonHolds,
        &[
            Data(|s| s.bounding_polygons[1].high = short(f64::from(s.bounding_polygons[1].high.get()) - 0.1)),
            Data(|s| {
                let support = &mut s.bounding_polygons[1].support[3];
                *support = short(f64::from(support.get()) * 0.9);
            }),
            Data(|s| s.bounding_polygons[0].normal.uv[0] = 9999.into()),
        ],
    ),
    (
        Rule::VertexActive,
        &[
            Data(|s| s.vertices[0].bound = ShortFloat::ZERO),
            Data(|s| s.vertices[1].budget = short(0.5)),
            Data(|s| s.vertices[0].radius = short(0.01)),
            Data(|s| s.vertices[0].offset = [127; 3]),
        ],
    ),
];

#[test]
fn every_rule_is_told_by_its_name_when_broken() {
    let sample = Sample::patches(6, 4, 24);
    sample.tree().verify().unwrap();
    for (rule, breaks) in BREAKS {
        for (number, way) in breaks.iter().enumerate() {
            let found = Tree::from_bytes(way.apply(&sample)).and_then(|t| t.verify());
            let error = found.expect_err(&format!("{} broken by way {number}", rule.name()));
            assert_eq!(error.rule(), Some(*rule), "way {number}: {error}");
            assert_eq!((error.code(), error.exit_code()), (rule.code(), 7));
        }
    }
    let tested: BTreeSet<_> = BREAKS.iter().map(|(rule, _)| rule.code()).collect();
    let all: BTreeSet<_> = Rule::ALL.iter().map(|rule| rule.code()).collect();
    assert_eq!(tested, all, "every rule has a test, once");
    assert_eq!(BREAKS.len(), all.len());
}

#[test]
fn sections_that_need_not_be_understood_are_ignored() {
    let sample = Sample::patches(4, 3, 24);
    let mut bytes = sample.bytes();
    put_entry(&mut bytes, b"COLR", 0, b"XYZ1");
    rehash(&mut bytes);
    let tree = Tree::from_bytes(bytes).unwrap();
    assert_eq!(tree.colors(), None);
    assert_eq!(tree.sections().last().unwrap().tag.to_string(), "XYZ1");
    tree.verify().unwrap();
}

#[test]
fn the_deepest_tree_allowed_is_allowed() {
    // A fan split one by one has its last faces at depth n - 1.
    let sample = Sample::fan(fct::MAX_DEPTH + 1, Split::OneByOne);
    assert_eq!(sample.tree().verify().unwrap().depth, fct::MAX_DEPTH);
    let deeper = Sample::fan(fct::MAX_DEPTH + 2, Split::OneByOne);
    let error = deeper.tree().verify().unwrap_err();
    assert_eq!(error.rule(), Some(Rule::Depth));
}

/// A small generator with a fixed seed (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

/// Numbers at which checks go wrong.
const AWKWARD: [u32; 8] = [0, 1, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, 0x7F80_0000, 0x7FC0_0000, 64];

/// Uses an unverified tree as a reader would.
fn walk(tree: &Tree) {
    let reader = tree.reader();
    let mut stack = vec![tree.whole()];
    let mut steps = 0;
    let mut loops = Loops::default();
    while let Some(subtree) = stack.pop() {
        steps += 1;
        if reader.read_loops(&subtree, &mut loops).is_ok() {
            assert!(loops.vertices.iter().all(|v| (*v as usize) < tree.vertices().len()));
        }
        match subtree.child.kind() {
            Child::Face(_) => {
                if let Ok(corners) = reader.face(&subtree) {
                    assert!(corners.iter().all(|v| (*v as usize) < tree.vertices().len()));
                }
            }
            Child::Node(node) => {
                if let Ok(node) = reader.node(&subtree) {
                    let _ = (node.axis(), node.cos(), node.epsilon());
                }
                let _ = tree.bounding_polygon_of(node);
                if let Ok(children) = reader.children(&subtree) {
                    stack.extend(children);
                }
            }
        }
        assert!(steps < 2 * tree.face_count(), "the walk does not end");
    }
    let _ = tree.faces();
    let _ = tree.find(fct::ChildRef::node(tree.header().node_count as u32 / 2));
}

#[test]
fn edits_with_right_hashes_never_panic_or_hang() {
    let whole = Sample::patches(6, 4, 24).bytes();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let start = Instant::now();
    let mut opened = 0;
    for _ in 0..30_000 {
        let mut bytes = whole.clone();
        for _ in 0..=random.below(3) {
            // Half of the edits go to header and table, where few bytes do much.
            let range = if random.below(2) == 0 { 1024 } else { bytes.len() };
            let at = 16 + 4 * random.below((range - 16) / 4);
            let value = match random.below(3) {
                0 => AWKWARD[random.below(AWKWARD.len())],
                1 => random.below(64) as u32,
                _ => random.below(1 << 32) as u32,
            };
            put(&mut bytes, at, &value.to_le_bytes());
        }
        // The count of sections decides where the helper's table ends, so it stays.
        bytes[40..48].copy_from_slice(&whole[40..48]);
        rehash(&mut bytes);
        if let Ok(tree) = Tree::from_bytes(bytes) {
            opened += 1;
            let _ = tree.verify();
            walk(&tree);
        }
    }
    assert!(opened > 3_000, "{opened} opened: the edits should reach beyond the header");
    assert!(start.elapsed() < Duration::from_secs(60));
}
