//! Small valid trees to start from, made by the slow and obvious way, and the means to damage them.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::collections::BTreeMap;

use fct::{
    BoundingPolygonRecord, ChildRef, ChunkData, ClusterData, GroupRecord, LOOP_END, Meta, NormalRecord,
    Packed, PlainClusters, Plan, Tree, TreeData, VertexRecord, WeldRecord, WriteOptions,
};
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

/// Everything that a file holds, owned.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub(crate) meta: Meta,
    /// What was packed.
    pub(crate) plain: PlainClusters,
    /// The most faces of a page.
    pub(crate) page_faces: u32,
    pub(crate) packed: Packed,
    pub(crate) vertices: Vec<VertexRecord>,
    pub(crate) weld: Vec<WeldRecord>,
    pub(crate) bounding_polygons: Vec<BoundingPolygonRecord>,
    pub(crate) normals: Option<Vec<NormalRecord>>,
    pub(crate) colors: Option<Vec<[u8; 4]>>,
    pub(crate) groups: Vec<GroupRecord>,
    pub(crate) chunks: Option<ChunkData>,
    /// The range of faces of each node.
    ranges: Vec<(usize, usize)>,
}

impl Sample {
    pub(crate) fn data(&self) -> TreeData<'_> {
        TreeData {
            meta: &self.meta,
            clusters: &self.packed,
            vertices: &self.vertices,
            weld: &self.weld,
            bounding_polygons: &self.bounding_polygons,
            normals: self.normals.as_deref(),
            colors: self.colors.as_deref(),
            groups: &self.groups,
            chunks: self.chunks.as_ref(),
        }
    }

    /// The same with chunks of at most so many faces.
    pub(crate) fn in_chunks(mut self, chunk_faces: u32) -> Self {
        let chunks = ChunkData::with_faces(
            &self.packed,
            &self.vertices,
            self.normals.as_deref(),
            self.colors.as_deref(),
            chunk_faces,
        );
        self.chunks = Some(chunks.unwrap());
        self
    }

    /// The bytes of the file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sample.fct");
        fct::write(&path, &self.data(), &WriteOptions::default()).unwrap();
        std::fs::read(path).unwrap()
    }

    pub(crate) fn tree(&self) -> Tree {
        Tree::from_bytes(self.bytes()).unwrap()
    }

    /// Two wavy patches of `2 * columns * rows` faces each that share a cut seam, under a virtual root; every section is there.
    pub(crate) fn patches(columns: u32, rows: u32, page_faces: u32) -> Self {
        let mut mesh = Mesh::default();
        for side in 0..2 {
            let first = u32::try_from(mesh.positions.len()).unwrap();
            for y in 0..=rows {
                for x in 0..=columns {
                    let (x, y) = ((x + side * columns) as f32, y as f32);
                    let z = 0.05 * ((x * 7.0 + y * 3.0) % 5.0);
                    mesh.positions.push([x, y, z]);
                }
            }
            for y in 0..rows {
                for x in 0..columns {
                    let a = first + y * (columns + 1) + x;
                    let c = a + columns + 1;
                    mesh.faces.push([a, a + 1, c + 1]);
                    mesh.faces.push([a, c + 1, c]);
                }
            }
        }
        let per_side = (columns + 1) * (rows + 1);
        let mut sample = Self::of_mesh(&mut mesh, Split::Halves, page_faces);
        for y in 0..=rows {
            let left = mesh.renamed[&(y * (columns + 1) + columns)];
            let right = mesh.renamed[&(per_side + y * (columns + 1))];
            sample.weld.push(WeldRecord { vertex: right.into(), representative: left.into() });
            for vertex in [left, right] {
                let position = sample.plain.positions[vertex as usize];
                let always = VertexRecord::eager(position, f64::INFINITY, f64::INFINITY, ([0.0; 3], 0.0));
                sample.vertices[vertex as usize] = always.unwrap();
            }
        }
        sample.weld.sort_by_key(|w| w.vertex.get());
        let root = &mut sample.plain.clusters[0];
        root.bound = f32::INFINITY;
        root.budget = f32::INFINITY;
        sample.pack();
        let tree = sample.tree();
        let halves = tree.children(&tree.whole()).unwrap();
        for (name, half) in halves.iter().enumerate() {
            sample.groups.push(GroupRecord {
                root: half.child.raw().into(),
                first_face: half.first_face.into(),
                face_count: half.face_count().into(),
                name: (name as u32).into(),
            });
        }
        sample.meta.group_names = vec!["left".to_owned(), "right".to_owned()];
        sample.meta.seam_edges = u64::from(rows);
        sample.meta.components = 2;
        sample.normals = Some(vec![NormalRecord::encode([0.1, 0.2, 0.9]); sample.vertices.len()]);
        sample.colors = Some(vec![[200, 150, 100, 255]; sample.vertices.len()]);
        sample
    }

    /// A fan of `faces` triangles, split in halves or one by one.
    pub(crate) fn fan(faces: u32, split: Split) -> Self {
        let mut mesh = Mesh::default();
        mesh.positions.push([0.0; 3]);
        for i in 0..=faces {
            let t = i as f32 / faces as f32;
            mesh.positions.push([1.0 - t, t, 0.0]);
        }
        for i in 0..faces {
            mesh.faces.push([0, i + 1, i + 2]);
        }
        Self::of_mesh(&mut mesh, split, 16)
    }

    fn of_mesh(mesh: &mut Mesh, split: Split, page_faces: u32) -> Self {
        mesh.order_vertices();
        let face_count = mesh.faces.len() as u32;
        let mut sample = Self {
            meta: Meta {
                generator: "a test".to_owned(),
                split: "halves".to_owned(),
                weld: "exact".to_owned(),
                source: "sample.ply".to_owned(),
                faces_in: u64::from(face_count) + 3,
                faces_kept: u64::from(face_count),
                dropped: vec![("repeated index".to_owned(), 3)],
                components: 1,
                bounds_min: bound(&mesh.positions, f32::min),
                bounds_max: bound(&mesh.positions, f32::max),
                ..Meta::default()
            },
            plain: PlainClusters {
                faces: mesh.faces.clone(),
                positions: mesh.positions.clone(),
                ..PlainClusters::default()
            },
            page_faces,
            packed: Packed::default(),
            vertices: Vec::new(),
            weld: Vec::new(),
            bounding_polygons: Vec::new(),
            normals: None,
            colors: None,
            groups: Vec::new(),
            chunks: None,
            ranges: Vec::new(),
        };
        // As eager as the root and as wide as all nodes can be.
        let center = bound(&mesh.positions, |a, b| (a + b) / 2.0).map(f64::from);
        let farthest = mesh.positions.iter().map(|p| distance(p.map(f64::from), center)).fold(0.0, f64::max);
        for position in &mesh.positions {
            let key = f64::from(face_count);
            sample.vertices.push(VertexRecord::eager(*position, key, key, (center, 3.0 * farthest)).unwrap());
        }
        sample.add_subtree(0, face_count, split, 0);
        sample.pack();
        sample
    }

    /// Packs what is plain once more.
    pub(crate) fn pack(&mut self) {
        let plan = Plan::new(&self.plain, self.page_faces).unwrap();
        let runs: Vec<_> =
            (0..plan.page_count()).map(|page| plan.pack_pages(&self.plain, page..page + 1)).collect();
        self.packed = Packed::assemble(&self.plain, &plan, runs).unwrap();
        self.bounding_polygons.clear();
        let mut decoded = self.packed.decoded(&plan);
        for (index, &(first, end)) in (0..).zip(&self.ranges) {
            let node = decoded.node(index).unwrap();
            if end - first >= 8 {
                let corners = self.plain.faces[first..end].iter().flatten();
                let points = corners.map(|v| self.plain.positions[*v as usize]);
                let polygon = BoundingPolygonRecord::around(index, &node, [0.0, 0.0, 1.0], points);
                self.bounding_polygons.push(polygon);
            }
        }
    }

    /// Appends the nodes over a range of faces, a node before its descendants.
    fn add_subtree(&mut self, first: u32, end: u32, split: Split, depth: u32) -> ChildRef {
        if end - first == 1 {
            self.meta.depth = self.meta.depth.max(depth);
            return ChildRef::face(first);
        }
        let index = self.ranges.len();
        let middle = match split {
            Split::Halves => first + (end - first) / 2,
            Split::OneByOne => first + 1,
        };
        let (start, stop) = (first as usize, end as usize);
        let cluster = &self.plain.faces[start..stop];
        self.ranges.push((start, stop));
        self.plain.left_faces.push(middle - first);
        self.plain.boundaries.push(boundary_of(cluster));
        self.plain.clusters.push(ClusterData {
            plane: [0.0; 3],
            offset: 0.0,
            bound: (end - first) as f32,
            budget: (end - first) as f32,
            axis: [0.0, 0.0, 1.0],
            cos: 0.5,
            epsilon: 0.25,
        });
        self.add_subtree(first, middle, split, depth + 1);
        self.add_subtree(middle, end, split, depth + 1);
        ChildRef::node(index as u32)
    }
}

/// How a range of faces is divided.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Split {
    Halves,
    OneByOne,
}

#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    renamed: BTreeMap<u32, u32>,
}

impl Mesh {
    /// Renames vertices in order of first use.
    fn order_vertices(&mut self) {
        let mut positions = Vec::new();
        for corner in self.faces.iter_mut().flatten() {
            let old = *corner;
            *corner = *self.renamed.entry(old).or_insert_with(|| {
                positions.push(self.positions[old as usize]);
                positions.len() as u32 - 1
            });
        }
        self.positions = positions;
    }
}

fn bound(positions: &[[f32; 3]], pick: fn(f32, f32) -> f32) -> [f32; 3] {
    positions
        .iter()
        .copied()
        .fold(positions[0], |a, b| [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The loops around some faces, with the end flags: directed edges without an opposite, chained.
fn boundary_of(faces: &[[u32; 3]]) -> Vec<u32> {
    let mut edges = Vec::new();
    for &[a, b, c] in faces {
        edges.extend([(a, b), (b, c), (c, a)]);
    }
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(a, b) in &edges {
        if !edges.contains(&(b, a)) {
            next.entry(a).or_default().push(b);
        }
    }
    let mut loops = Vec::new();
    while let Some((&start, _)) = next.iter().find(|(_, ends)| !ends.is_empty()) {
        let mut at = start;
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            loops.push(at);
            at = to;
        }
        *loops.last_mut().unwrap() |= LOOP_END;
    }
    loops
}

/// Where a section stands in a file: its entry in the table, its offset, its length.
pub(crate) fn section(bytes: &[u8], tag: &[u8; 4]) -> (usize, usize, usize) {
    let count = read_u32(bytes, 40) as usize;
    (0..count)
        .map(|i| 128 + 64 * i)
        .find(|entry| bytes[*entry..*entry + 4] == *tag)
        .map(|entry| (entry, read_u64(bytes, entry + 8) as usize, read_u64(bytes, entry + 16) as usize))
        .unwrap()
}

/// Makes all hashes right again after an edit, as an attacker would.
pub(crate) fn rehash(bytes: &mut [u8]) {
    let table_end = 128 + 64 * (read_u32(bytes, 40) as usize).min(64);
    let mut content = Xxh3::new();
    for entry in (128..table_end).step_by(64) {
        let start = read_u64(bytes, entry + 8) as usize;
        let end = start.saturating_add(read_u64(bytes, entry + 16) as usize);
        let Some(payload) = bytes.get(start..end) else {
            continue;
        };
        content.update(payload);
        let hash = xxh3_64(payload);
        bytes[entry + 40..entry + 48].copy_from_slice(&hash.to_le_bytes());
    }
    bytes[80..96].copy_from_slice(&content.digest128().to_le_bytes());
    rehash_header(bytes);
}

/// Makes the hash of header and table right again.
pub(crate) fn rehash_header(bytes: &mut [u8]) {
    let table_end = 128 + 64 * (read_u32(bytes, 40) as usize).min(64);
    let mut hashed = bytes[..120].to_vec();
    hashed.extend_from_slice(&bytes[128..table_end.min(bytes.len())]);
    let hash = xxh3_64(&hashed);
    bytes[120..128].copy_from_slice(&hash.to_le_bytes());
}

pub(crate) fn read_u32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

pub(crate) fn read_u64(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}
