//! Colours for clusters, such that neighbours differ.

/// Colours that are told apart with dark lines between them, and in light and shade.
const COLORS: [[u8; 3]; 12] = [
    [126, 182, 226],
    [246, 189, 96],
    [148, 203, 130],
    [233, 134, 130],
    [190, 164, 219],
    [243, 226, 134],
    [114, 200, 188],
    [240, 172, 200],
    [176, 140, 110],
    [196, 214, 226],
    [86, 140, 176],
    [206, 222, 152],
];

/// A colour for each of `clusters` clusters, given which ones touch.
///
/// In order, each takes among the colours that no neighbour has the one used least so far; clusters on a surface
/// touch about six others, so a dozen colours nearly always have one left.
pub(crate) fn colors(clusters: usize, touching: &[(u32, u32)]) -> Vec<[u8; 3]> {
    let mut neighbours = vec![Vec::new(); clusters];
    for &(a, b) in touching {
        if a != b && (a as usize) < clusters && (b as usize) < clusters {
            neighbours[a as usize].push(b as usize);
            neighbours[b as usize].push(a as usize);
        }
    }
    let mut chosen = vec![usize::MAX; clusters];
    let mut used = [0_usize; COLORS.len()];
    for i in 0..clusters {
        let mut near = [0_usize; COLORS.len()];
        for &j in &neighbours[i] {
            if let Some(n) = near.get_mut(chosen[j]) {
                *n += 1;
            }
        }
        let best = (0..COLORS.len()).min_by_key(|&c| (near[c], used[c], c)).unwrap_or(0);
        chosen[i] = best;
        used[best] += 1;
    }
    chosen.into_iter().map(|c| COLORS[c]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a grid of squares that touch eight others, no two that touch look alike.
    #[test]
    fn neighbours_differ() {
        let at = |x: u32, y: u32| y * 20 + x;
        let mut touching = Vec::new();
        for y in 0..19 {
            for x in 0..19 {
                touching.extend([
                    (at(x, y), at(x + 1, y)),
                    (at(x, y + 1), at(x, y)),
                    (at(x, y), at(x + 1, y + 1)),
                    (at(x + 1, y), at(x, y + 1)),
                ]);
            }
        }
        let colors = colors(400, &touching);
        assert!(touching.iter().all(|&(a, b)| colors[a as usize] != colors[b as usize]));
        let mut all: Vec<_> = colors;
        all.sort_unstable();
        all.dedup();
        assert!(all.len() > 8, "few colours are used: {}", all.len());
    }
}
