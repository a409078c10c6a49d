//! Every rule of the format, in one place.
//!
//! The writer, [`crate::Tree::open`], [`crate::Tree::children`] and [`crate::Tree::verify`] all name their findings by this list,
//! and so does `SPEC.md`.

macro_rules! rules {
    ($($(#[$doc:meta])* $variant:ident, $code:literal, $name:literal, $promise:literal, $remedy:literal;)*) => {
        /// A rule that a `.fct` file must keep.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Rule {
            $(#[doc = $promise] $variant,)*
        }

        impl Rule {
            /// Every rule, in the order in which they are checked, more or less.
            pub const ALL: &'static [Rule] = &[$(Rule::$variant,)*];

            /// The stable code of an error that says this rule is broken, such as `FC701`.
            pub const fn code(self) -> &'static str {
                match self { $(Rule::$variant => $code,)* }
            }

            /// The short name of the rule, such as `file-length`.
            pub const fn name(self) -> &'static str {
                match self { $(Rule::$variant => $name,)* }
            }

            /// What must hold, as a clause.
            pub const fn promise(self) -> &'static str {
                match self { $(Rule::$variant => $promise,)* }
            }

            /// What the user can do about it.
            pub const fn remedy(self) -> &'static str {
                match self { $(Rule::$variant => $remedy,)* }
            }
        }
    };
}

rules! {
    // Container: checked by open.
    Signature, "FC701", "signature", "the file starts with the bytes 8F 46 43 54 0D 0A 1A 0A",
        "give a .fct file; a mesh is turned into one by `fcbuild MESH -o OUT.fct`";
    TooShort, "FC702", "too-short", "the file holds at least the 128 bytes of the header",
        "copy the file again or rebuild it with fcbuild";
    ByteOrder, "FC703", "byte-order", "the byte order tag reads 0x01020304",
        "the file was byte-swapped on its way: copy it again as binary";
    Version, "FC704", "version", "the version is one that this program reads",
        "use the fcbuild and the reader of one release";
    FileLength, "FC705", "file-length", "the length in the header equals the length of the file",
        "the file is truncated or has bytes appended: copy it again or rebuild it with fcbuild";
    Features, "FC706", "features", "every required feature is known",
        "use the fcbuild and the reader of one release";
    HeaderHash, "FC707", "header-hash", "the hash of header and section table matches",
        "the file is damaged: copy it again or rebuild it with fcbuild";
    ReservedZero, "FC708", "reserved-zero", "reserved bytes are zero",
        "rebuild the file with fcbuild";
    SectionCount, "FC709", "section-count", "there are 1 to 64 sections",
        "rebuild the file with fcbuild";
    TablePlace, "FC710", "table-place", "the section table lies at byte 128, inside the file, with entries of 64 bytes or a larger multiple of 8",
        "rebuild the file with fcbuild";
    SectionPlace, "FC711", "section-place", "sections stand in file order, aligned, with nothing but padding between them, and the last ends with the file",
        "rebuild the file with fcbuild";
    SectionSize, "FC712", "section-size", "a section's length is its element size times its element count",
        "rebuild the file with fcbuild";
    SectionTag, "FC713", "section-tag", "section tags are unique",
        "rebuild the file with fcbuild";
    SectionRequired, "FC714", "section-required", "the sections META, TOPN, TOPL, PAGE, NODE, FACE, LOOP, LINK and VERT are there",
        "rebuild the file with fcbuild";
    SectionKnown, "FC715", "section-known", "sections that must be understood are known",
        "use the fcbuild and the reader of one release";
    HashKind, "FC716", "hash-kind", "section hashes are of kind 1 (XXH3-64)",
        "use the fcbuild and the reader of one release";
    Counts, "FC717", "counts", "the counts of nodes, vertices, faces and of what belongs to them agree",
        "rebuild the file with fcbuild";
    RootPlace, "FC718", "root", "the root is node 0, or face 0 when there is but one face",
        "rebuild the file with fcbuild";
    MetaReadable, "FC719", "meta", "section META holds one description of at most 1 MiB and nothing else",
        "rebuild the file with fcbuild";
    // Bytes: checked by verify.
    SectionHash, "FC721", "section-hash", "the hash of every section matches",
        "the file is damaged: copy it again or rebuild it with fcbuild";
    ContentId, "FC722", "content-id", "the content id matches the sections",
        "the file is damaged: copy it again or rebuild it with fcbuild";
    PaddingZero, "FC723", "padding-zero", "padding between sections is zero",
        "the file is damaged: copy it again or rebuild it with fcbuild";
    // Structure: checked by children, loops_of and verify.
    ChildPlace, "FC731", "preorder", "nodes and faces stand in preorder, each reached exactly once",
        "rebuild the file with fcbuild";
    FaceRange, "FC732", "face-range", "the face ranges of two children split their parent's",
        "rebuild the file with fcbuild";
    Depth, "FC733", "depth", "no face lies deeper than 96",
        "rebuild the file with fcbuild";
    VertexIndex, "FC734", "vertex-index", "vertex indices are below the number of vertices",
        "rebuild the file with fcbuild";
    VertexOrder, "FC735", "vertex-order", "vertices stand in order of first use by the faces, and all are used",
        "rebuild the file with fcbuild";
    LoopRange, "FC736", "loop-range", "a node's loops lie in section LOOP or TOPL and end there",
        "rebuild the file with fcbuild";
    LoopCover, "FC737", "loop-cover", "every byte of sections LOOP and TOPL belongs to exactly one node, in preorder",
        "rebuild the file with fcbuild";
    LoopBoundary, "FC738", "loop-boundary", "a node's loops are the boundary of its faces, with the cluster on the left",
        "rebuild the file with fcbuild";
    WeldOrder, "FC739", "weld", "weld records are sorted by vertex, and a representative is itself no copy",
        "rebuild the file with fcbuild";
    WeldEqual, "FC740", "weld-equal", "a welded copy has the record of its representative",
        "rebuild the file with fcbuild";
    PolygonOrder, "FC741", "bounding-polygon-order", "bounding polygons are sorted by node, one a node at most",
        "rebuild the file with fcbuild";
    GroupRange, "FC742", "group", "groups are sorted and disjoint, and each has a name and the face range of its root",
        "rebuild the file with fcbuild";
    MetaAgrees, "FC743", "meta-agrees", "the description agrees with the tree",
        "rebuild the file with fcbuild";
    PageRange, "FC744", "page", "pages own the faces, vertices, links and loop bytes one after the other, and have 1 to 253 faces and at most 256 vertices",
        "rebuild the file with fcbuild";
    LinkOrder, "FC745", "link", "the links of a page ascend and lie before its own vertices, and its faces use all of its vertices",
        "rebuild the file with fcbuild";
    Chunk, "FC746", "chunk", "sections CRPG and CHTP are those that follow from the tree",
        "the file is damaged: copy it again or rebuild it with fcbuild";
    // Values: checked by verify.
    Finite, "FC751", "finite", "numbers are finite, but for bounds and budget keys, which may be +inf, and a low is not above its high",
        "rebuild the file with fcbuild";
    NotNegative, "FC752", "not-negative", "radii, bounds, budget keys and epsilons are not negative",
        "rebuild the file with fcbuild";
    UnitVector, "FC753", "unit-vector", "axes have length 1, within 1e-4",
        "rebuild the file with fcbuild";
    Cosine, "FC754", "cosine", "cosines lie in -1 to 1",
        "rebuild the file with fcbuild";
    KeyOrder, "FC755", "key-order", "a child's bound and budget key are not above its parent's",
        "rebuild the file with fcbuild";
    Grid, "FC756", "grid", "a page's quantum is a power of two, and the steps of its grid are whole quanta and exact in single precision",
        "rebuild the file with fcbuild";
    // Geometry: checked by verify.
    SphereNested, "FC761", "sphere-nested", "a child's sphere lies inside its parent's",
        "rebuild the file with fcbuild";
    SphereHolds, "FC762", "sphere-holds-faces", "a cluster's faces lie inside its sphere",
        "rebuild the file with fcbuild";
    ConeHolds, "FC763", "cone-holds-normals", "the normals of a cluster of up to 64 faces lie inside its cone",
        "rebuild the file with fcbuild";
    PolygonHolds, "FC764", "bounding-polygon-holds", "a cluster lies inside its bounding polygon",
        "rebuild the file with fcbuild";
    VertexActive, "FC765", "vertex-active", "the corners of a face are active wherever the node above it is refined",
        "rebuild the file with fcbuild";
}

#[cfg(test)]
mod tests {
    use super::Rule;
    use std::collections::BTreeSet;

    #[test]
    fn codes_and_names_are_unique_and_in_order() {
        let codes: Vec<_> = Rule::ALL.iter().map(|r| r.code()).collect();
        assert!(codes.windows(2).all(|w| w[0] < w[1]));
        let names: BTreeSet<_> = Rule::ALL.iter().map(|r| r.name()).collect();
        assert_eq!(names.len(), codes.len());
    }

    #[test]
    fn the_specification_lists_every_rule() {
        let spec = include_str!("../SPEC.md");
        for rule in Rule::ALL {
            let row = format!("| {} | `{}` |", rule.code(), rule.name());
            assert!(spec.contains(&row), "SPEC.md lacks a row `{row}`");
        }
    }
}
