//! Triangles in parcels, each of which needs no more pages than there are slots.

use std::collections::BTreeSet;
use std::ops::Range;

/// Some triangles of a mesh whose pages are needed at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parcel {
    /// The mesh, by number.
    pub(crate) mesh: usize,
    /// Its corners, three a triangle.
    pub(crate) corners: Range<usize>,
    /// The pages, ascending.
    pub(crate) pages: Vec<u32>,
}

/// Divides a mesh into as few parcels of at most `most` pages as its order allows; three at least are allowed, so that
/// any triangle has room. `page` says which page a corner lies in.
pub(crate) fn parcels(mesh: usize, corners: &[u32], most: u32, page: impl Fn(u32) -> u32) -> Vec<Parcel> {
    let mut pages: Vec<u32> = corners.iter().map(|corner| page(*corner)).collect();
    pages.sort_unstable();
    pages.dedup();
    if pages.len() <= most as usize {
        return vec![Parcel { mesh, corners: 0..corners.len(), pages }];
    }
    let mut parcels = Vec::new();
    let mut open = BTreeSet::new();
    let mut start = 0;
    let mut end = 0;
    for triangle in corners.chunks(3) {
        let more = open.len() + triangle.iter().filter(|c| !open.contains(&page(**c))).count();
        // At most three: two corners in one new page are counted twice, which ends a parcel a little early.
        if more > most as usize && end > start {
            let pages = std::mem::take(&mut open).into_iter().collect();
            parcels.push(Parcel { mesh, corners: start..end, pages });
            start = end;
        }
        open.extend(triangle.iter().map(|corner| page(*corner)));
        end += triangle.len();
    }
    parcels.push(Parcel { mesh, corners: start..end, pages: open.into_iter().collect() });
    parcels
}

/// Groups consecutive parcels that together need at most `most` pages of `total`: each group is drawn at once.
pub(crate) fn groups(parcels: &[Parcel], most: u32, total: u32) -> Vec<Range<usize>> {
    // The group that last needed each page, counted from 1.
    let mut needed_by = vec![0_u32; total as usize];
    let mut groups = Vec::new();
    let mut number = 1;
    let mut start = 0;
    let mut pages = 0;
    for (at, parcel) in parcels.iter().enumerate() {
        let is_new = |page: &&u32| needed_by.get(**page as usize).is_some_and(|by| *by != number);
        let new = parcel.pages.iter().filter(is_new).count();
        if pages + new > most as usize && at > start {
            groups.push(start..at);
            (start, pages, number) = (at, parcel.pages.len(), number + 1);
        } else {
            pages += new;
        }
        for page in &parcel.pages {
            if let Some(by) = needed_by.get_mut(*page as usize) {
                *by = number;
            }
        }
    }
    groups.push(start..parcels.len());
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parcels_and_groups_keep_to_the_slots_and_leave_nothing_out() {
        let mut random = crate::random::Random::new(8);
        for most in [3, 4, 7, 20] {
            let mut all = Vec::new();
            for mesh in 0..12 {
                let corners: Vec<u32> = (0..3 * random.below(60)).map(|_| random.below(400) as u32).collect();
                let parcels = parcels(mesh, &corners, most, |corner| corner / 10);
                let mut end = 0;
                for parcel in &parcels {
                    assert_eq!((parcel.mesh, parcel.corners.start, parcel.corners.len() % 3), (mesh, end, 0));
                    end = parcel.corners.end;
                    let mut pages: Vec<u32> =
                        corners[parcel.corners.clone()].iter().map(|corner| corner / 10).collect();
                    pages.sort_unstable();
                    pages.dedup();
                    assert_eq!(pages, parcel.pages);
                    assert!(pages.len() <= most as usize);
                }
                assert_eq!(end, corners.len());
                all.extend(parcels);
            }
            let groups = groups(&all, most, 40);
            let mut end = 0;
            for group in &groups {
                assert_eq!(group.start, end);
                end = group.end;
                let mut pages: Vec<u32> =
                    all[group.clone()].iter().flat_map(|parcel| parcel.pages.clone()).collect();
                pages.sort_unstable();
                pages.dedup();
                assert!(pages.len() <= most as usize, "{} pages for {most} slots", pages.len());
            }
            assert_eq!(end, all.len());
            assert!(most < 20 || groups.len() < all.len(), "some are drawn together");
        }
    }

    #[test]
    fn nothing_to_draw_is_one_empty_group() {
        let groups = groups(&[], 3, 10);
        assert!(groups.len() == 1 && groups[0].is_empty());
    }
}
