//! Memory: what a job will take, what it may take, and what it took.
//!
//! # Measured
//! Largest resident size (`/usr/bin/time -v`) on x86-64 Linux, in bytes a face; `estimate` is that of this module.
//!
//! | mesh, two threads | faces | vertices | border edges | peak | estimate |
//! |-------------------|-------|----------|--------------|------|----------|
//! | Stanford bunny | 69,451 | 0.50 a face | 0 | 322 to 354 | 419 |
//! | Stanford dragon | 871,306 | 0.50 a face | 0 | 187 | 195 |
//! | the same, one and four threads | | | | 186, 191 | 195 |
//! | a sculpture | 1,001,664 | 0.50 a face | 0 | 188 | 193 |
//! | the same, one and four threads | | | | 187, 193 | 193 |
//! | a sculpture | 4,006,656 | 0.50 a face | 0 | 182 | 180 |
//! | squares, every fourth one missing | 1,215,000 | 0.67 a face | 0.67 a face | 290 to 296 | 315 |
//! | the same, at random heights up to the side of a square | 1,215,000 | 0.67 a face | 0.67 a face | 289 | 315 |
//! | the same, up to a tenth of that | 1,215,000 | 0.67 a face | 0.67 a face | 321 | 315 |
//! | a spiral strip | 399,998 | 1 a face | 1 a face | 412 | 418 |
//! | single squares | 400,000 | 2 a face | 2 a face | 540 | 643 |
//! | single triangles | 400,000 | 3 a face | 3 a face | 835 | 868 |
//! | triangles between random vertices | 399,998 | 3 a face, once cut | 3 a face, once cut | 880 | 868 |
//! | the dragon, split from the top | 871,306 | 0.50 a face | 0 | 237 | 239 |
//! | squares at random heights, merged too deep and then split from the top | 1,620,000 | 0.50 a face | 0 | 243 | 187 |
//!
//! The last row is the one that cannot be foreseen.
//! How threads take turns moves the peak by a hundredth; with the dynamic threshold of the GNU C library it was a tenth,
//! and the peak a fifth higher, see `fct::heap`.

use super::distinct;
use fcbuild::error::ErrorKind;
use fcbuild::import::Soup;
use fcbuild::mesh::Weld;
use fcbuild::{Error, Extent, SplitMode};
use fct::{Size, counted};
use std::fs;
use std::path::Path;

/// Bytes of a process that has built next to nothing: program, stacks, buffers.
const BASE: u64 = 16 << 20;

/// Bytes at the peak for each face. Too small, and jobs run out of memory; too large, and jobs are refused that fit.
const PER_FACE: u64 = 151;

/// The same while clusters are split from the top, whatever borders there are.
const PER_FACE_FROM_TOP: u64 = 195;

/// Bytes at the peak for each vertex.
const PER_VERTEX: u64 = 50;

/// Bytes at the peak for each edge on a border: every cluster has longer loops there, and curves have records.
const PER_BORDER_EDGE: u64 = 175;

/// The share of the memory that a job may plan with when the user gives no limit; the rest is for other programs and
/// for the pages of the files.
const DEFAULT_SHARE: f64 = 0.75;

/// The bytes that building `soup` will take at the peak, if it has no border and needs no seam; more if it has.
pub(crate) fn estimate_of_soup(soup: &Soup, weld: Weld, split: SplitMode) -> u64 {
    let vertices = match weld {
        Weld::Off => soup.positions.len() as u64,
        // Welding within a distance joins at least these.
        Weld::Exact | Weld::Within(_) => distinct::positions(&soup.positions),
    };
    estimate(&Extent { faces: soup.triangles.len() as u64, vertices, border_edges: 0 }, split)
}

/// The bytes that building such a surface will take at the peak, about.
pub(crate) fn estimate(extent: &Extent, split: SplitMode) -> u64 {
    let Extent { faces, vertices, border_edges } = *extent;
    let with = |per_face: u64, per_border_edge: u64| {
        let parts = [(faces, per_face), (vertices, PER_VERTEX), (border_edges, per_border_edge)];
        parts.into_iter().fold(BASE, |sum, (count, bytes)| sum.saturating_add(count.saturating_mul(bytes)))
    };
    let all = with(PER_FACE, PER_BORDER_EDGE);
    match split {
        SplitMode::Quality | SplitMode::Merge => all,
        SplitMode::Paper | SplitMode::Pca | SplitMode::Cca => all.max(with(PER_FACE_FROM_TOP, 0)),
    }
}

/// The most faces that can be built within `limit` bytes, whatever the number of vertices.
pub(crate) fn faces_within(limit: u64) -> u64 {
    (limit.saturating_sub(BASE) / PER_FACE).max(1)
}

/// The bytes that so many faces take at the least.
pub(crate) fn least_for(faces: u64) -> u64 {
    estimate(&Extent { faces, vertices: 0, border_edges: 0 }, SplitMode::Quality)
}

/// Holds the estimate against the limit.
///
/// # Errors
/// A limit error with both numbers.
pub(crate) fn check(estimate: u64, limit: Option<&Size>) -> Result<(), Error> {
    match limit {
        Some(limit) if estimate > limit.bytes() => Err(Error::new(
            ErrorKind::Limit,
            "FC506",
            format!("the job needs about {} of memory and may take {limit}", limit.same_unit(estimate)),
        )
        .remedy("raise --max-memory, or split or simplify the mesh")
        .limit(limit.bytes(), estimate)),
        _ => Ok(()),
    }
}

/// Says what so many faces, or more, need; for readers that give up while they read.
pub(crate) fn too_many_faces(faces: u64, limit: &Size) -> Error {
    let least = least_for(faces);
    Error::new(
        ErrorKind::Limit,
        "FC506",
        format!(
            "{} or more need {} of memory at least, and the job may take {limit}",
            counted(faces, "face"),
            limit.same_unit(least)
        ),
    )
    .remedy("raise --max-memory, or split or simplify the mesh")
    .limit(limit.bytes(), least)
}

/// What a job may take when the user gives no limit; `None` where the system does not tell.
pub(crate) fn default_limit() -> Option<u64> {
    let of_machine = kilobytes_after(&fs::read_to_string("/proc/meminfo").ok()?, "MemTotal:");
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let of_group = group_limits(&groups).into_iter().filter_map(|file| {
        // "max" and what else is no number is no limit.
        fs::read_to_string(file).ok()?.trim().parse::<u64>().ok()
    });
    let of_process = address_space(&fs::read_to_string("/proc/self/limits").unwrap_or_default());
    let smallest = of_group.chain(of_machine).chain(of_process).min()?;
    Some((smallest as f64 * DEFAULT_SHARE) as u64)
}

/// The bytes in the line `Max address space` of `/proc/self/limits`, the softer of the two; `unlimited` is none.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The highest resident size of this process so far; `None` where the system does not tell.
pub(crate) fn peak() -> Option<u64> {
    kilobytes_after(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Reads the number in a line such as `VmHWM:     1234 kB`.
fn kilobytes_after(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The files that may hold a memory limit of the control groups that `/proc/self/cgroup` lists: of each group and of
/// all above it.
fn group_limits(groups: &str) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (fields.next(), fields.next()) else { continue };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => continue,
        };
        let group = Path::new(group.trim_start_matches('/'));
        files.extend(group.ancestors().map(|above| Path::new(root).join(above).join(file)));
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_held() {
        assert!(check(100, None).is_ok() && check(100, Some(&Size::of_bytes(100))).is_ok());
        let surface = Extent { faces: 1_000_000, vertices: 500_000, border_edges: 0 };
        let error =
            check(estimate(&surface, SplitMode::Quality), Some(&Size::of_bytes(1 << 20))).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (5, "FC506"));
        assert!(error.message().contains("1.0 MB"), "{error}");
    }

    #[test]
    fn a_mesh_over_the_face_limit_is_over_the_memory_limit() {
        for limit in [1 << 20, 1 << 28, 1 << 35] {
            let faces = faces_within(limit) + 1;
            let extent = Extent { faces, vertices: 0, border_edges: 0 };
            assert!(estimate(&extent, SplitMode::Quality) > limit);
        }
    }

    #[test]
    fn numbers_of_the_kernel_are_read() {
        let status = "Name:\tfcbuild\nVmPeak:\t  99 kB\nVmHWM:\t    1234 kB\n";
        assert_eq!(kilobytes_after(status, "VmHWM:"), Some(1234 * 1024));
        assert_eq!(kilobytes_after(status, "VmSwap:"), None);
    }

    #[test]
    fn the_limit_on_the_address_space_counts() {
        let line = |soft: &str| {
            format!("Max processes 9 9 processes\nMax address space     {soft}    unlimited     bytes\n")
        };
        assert_eq!(address_space(&line("102400000")), Some(102_400_000));
        assert_eq!(address_space(&line("unlimited")), None);
        assert_eq!(address_space(""), None);
    }

    #[test]
    fn limits_of_all_control_groups_above_count() {
        let files = |text| group_limits(text).iter().map(|p| p.display().to_string()).collect::<Vec<_>>();
        let two = files("0::/user.slice/job.scope\n");
        assert_eq!(
            two,
            [
                "/sys/fs/cgroup/user.slice/job.scope/memory.max",
                "/sys/fs/cgroup/user.slice/memory.max",
                "/sys/fs/cgroup/memory.max"
            ]
        );
        assert_eq!(
            files("3:cpu:/x\n4:hugetlb,memory:/a"),
            ["/sys/fs/cgroup/memory/a/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.limit_in_bytes"]
        );
    }
}
