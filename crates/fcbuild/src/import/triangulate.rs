//! Cuts polygons of any shape into triangles that use every corner.
//!
//! A quad gets the shorter of its valid diagonals, a convex polygon a fan, any other one is clipped
//! ear by ear in the plane of its Newell normal. `n` corners always give `n - 2` triangles with the
//! polygon's winding, so that the edges of neighbouring polygons still meet.

/// How well a polygon could be cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The triangles tile the polygon.
    Simple,
    /// The polygon crosses itself or folds over; some triangles overlap.
    SelfCrossing,
    /// The search for ears took too long and the rest was cut as a fan.
    TooComplex,
}

/// Point visits allowed per corner. Ordinary outlines need a few dozen; a hostile tangle would take
/// the square of its corners. Too small a number turns long concave outlines into fans.
const VISITS_PER_CORNER: usize = 2_000;

/// Buffers that are kept from polygon to polygon.
#[derive(Default)]
pub(super) struct Triangulator {
    points: Vec<[f64; 2]>,
    previous: Vec<usize>,
    next: Vec<usize>,
    reflex: Vec<bool>,
    grid: ReflexGrid,
}

/// The reflex corners by square cells, so that an ear is compared with its neighbourhood only.
#[derive(Default)]
struct ReflexGrid {
    side: usize,
    low: [f64; 2],
    scale: [f64; 2],
    starts: Vec<usize>,
    items: Vec<usize>,
}

impl Triangulator {
    /// Appends the triangles of a polygon of at least three `corners`.
    pub(super) fn triangulate(
        &mut self,
        position: impl Fn(u32) -> [f64; 3],
        corners: &[u32],
        out: &mut Vec<[u32; 3]>,
    ) -> Verdict {
        match *corners {
            [] | [_] | [_, _] => Verdict::Simple,
            [a, b, c] => {
                out.push([a, b, c]);
                Verdict::Simple
            }
            [a, b, c, d] => quad([a, b, c, d], [a, b, c, d].map(position), out),
            _ => self.outline(position, corners, out),
        }
    }

    fn outline(
        &mut self,
        position: impl Fn(u32) -> [f64; 3],
        corners: &[u32],
        out: &mut Vec<[u32; 3]>,
    ) -> Verdict {
        let n = corners.len();
        let normal = newell(corners.iter().map(|&c| position(c)));
        // Dropping the longest axis of the normal keeps the coordinates exact and the area largest.
        let drop =
            (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()).then(b.cmp(&a))).unwrap_or(2);
        let (mut u, mut v) = ((drop + 1) % 3, (drop + 2) % 3);
        if normal[drop] < 0.0 {
            (u, v) = (v, u);
        }
        self.points.clear();
        self.points.extend(corners.iter().map(|&c| position(c)).map(|p| [p[u], p[v]]));
        self.previous.clear();
        self.previous.extend((0..n).map(|i| if i == 0 { n - 1 } else { i - 1 }));
        self.next.clear();
        self.next.extend((0..n).map(|i| if i + 1 == n { 0 } else { i + 1 }));
        self.reflex.clear();
        for i in 0..n {
            let turn = self.turn(i);
            self.reflex.push(turn <= 0.0 || turn.is_nan());
        }
        if !self.reflex.contains(&true) && turns_once(&self.points) {
            out.extend((1..n - 1).map(|i| [corners[0], corners[i], corners[i + 1]]));
            return Verdict::Simple;
        }
        self.grid.build(&self.points, &self.reflex);
        self.clip(corners, out)
    }

    fn turn(&self, i: usize) -> f64 {
        turn(self.points[self.previous[i]], self.points[i], self.points[self.next[i]])
    }

    fn clip(&mut self, corners: &[u32], out: &mut Vec<[u32; 3]>) -> Verdict {
        let mut verdict = Verdict::Simple;
        let mut left = corners.len();
        let mut visits = VISITS_PER_CORNER.saturating_mul(left);
        let mut at = 0;
        let mut tried = 0;
        while left > 3 {
            if visits == 0 {
                self.fan(at, corners, out);
                return Verdict::TooComplex;
            }
            visits -= 1;
            if !self.reflex[at] && self.is_ear(at, &mut visits) {
                // Stepping two on after a cut spreads the ears and avoids one fan of slivers.
                let after = self.cut(at, corners, out);
                at = self.next[after];
                left -= 1;
                tried = 0;
            } else {
                at = self.next[at];
                tried += 1;
            }
            if tried >= left {
                // No ear is left: what remains has no area or crosses itself.
                let (victim, flat) = self.least_harm(at);
                if !flat {
                    verdict = Verdict::SelfCrossing;
                }
                at = self.cut(victim, corners, out);
                left -= 1;
                tried = 0;
                visits = visits.saturating_sub(left);
            }
        }
        out.push([corners[self.previous[at]], corners[at], corners[self.next[at]]]);
        verdict
    }

    /// Cuts off corner `i` and returns the one after it.
    fn cut(&mut self, i: usize, corners: &[u32], out: &mut Vec<[u32; 3]>) -> usize {
        let (p, q) = (self.previous[i], self.next[i]);
        out.push([corners[p], corners[i], corners[q]]);
        self.next[p] = q;
        self.previous[q] = p;
        self.reflex[i] = false;
        for k in [p, q] {
            // A corner only ever opens up as its neighbours are cut, so the grid needs no additions.
            if self.reflex[k] {
                let turn = self.turn(k);
                self.reflex[k] = turn <= 0.0 || turn.is_nan();
            }
        }
        q
    }

    fn is_ear(&self, i: usize, visits: &mut usize) -> bool {
        let (p, q) = (self.previous[i], self.next[i]);
        let (a, b, c) = (self.points[p], self.points[i], self.points[q]);
        // The corner may have closed up when a neighbour of a tangled outline was cut.
        let opens = turn(a, b, c) > 0.0;
        if !opens {
            return false;
        }
        let low = [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1])];
        let high = [a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])];
        let (from, to) = (self.grid.cell(low), self.grid.cell(high));
        for y in from[1]..=to[1] {
            *visits = visits.saturating_sub(to[0] - from[0] + 1);
            let row = y * self.grid.side;
            let items = self.grid.starts[row + from[0]]..self.grid.starts[row + to[0] + 1];
            *visits = visits.saturating_sub(items.len());
            for &k in &self.grid.items[items] {
                let x = self.points[k];
                // A hole is often joined to the outline by an edge that is walked twice: a corner at
                // the same place as one of the ear's does not block it.
                let inside = self.reflex[k]
                    && k != p
                    && k != q
                    && x != a
                    && x != b
                    && x != c
                    && turn(a, b, x) >= 0.0
                    && turn(b, c, x) >= 0.0
                    && turn(c, a, x) >= 0.0;
                if inside {
                    return false;
                }
            }
        }
        true
    }

    /// The corner whose cut does least harm where there is no ear: the flattest, and whether it is
    /// exactly flat.
    fn least_harm(&self, start: usize) -> (usize, bool) {
        let (mut best, mut best_turn) = (start, self.turn(start).abs());
        let mut i = self.next[start];
        while i != start {
            let t = self.turn(i).abs();
            if t.total_cmp(&best_turn).is_lt() {
                (best, best_turn) = (i, t);
            }
            i = self.next[i];
        }
        (best, best_turn == 0.0)
    }

    fn fan(&self, apex: usize, corners: &[u32], out: &mut Vec<[u32; 3]>) {
        let mut b = self.next[apex];
        while self.next[b] != apex {
            out.push([corners[apex], corners[b], corners[self.next[b]]]);
            b = self.next[b];
        }
    }
}

impl ReflexGrid {
    fn build(&mut self, points: &[[f64; 2]], reflex: &[bool]) {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for p in points {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let reflex_count = reflex.iter().filter(|r| **r).count();
        self.side = (1..=256).find(|s| s * s >= reflex_count).unwrap_or(256);
        self.low = low;
        for k in 0..2 {
            let extent = high[k] - low[k];
            self.scale[k] = if extent > 0.0 { self.side as f64 / extent } else { 0.0 };
        }
        // A counting sort: first how many per cell, then where each cell starts, then the corners.
        self.starts.clear();
        self.starts.resize(self.side * self.side + 1, 0);
        let members = || (0..points.len()).filter(|&i| reflex[i]);
        let index = |grid: &Self, i: usize| {
            let [x, y] = grid.cell(points[i]);
            y * grid.side + x
        };
        for i in members() {
            let cell = index(self, i);
            self.starts[cell + 1] += 1;
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        self.items.clear();
        self.items.resize(reflex_count, 0);
        let mut fill = self.starts.clone();
        for i in members() {
            let cell = index(self, i);
            self.items[fill[cell]] = i;
            fill[cell] += 1;
        }
    }

    fn cell(&self, p: [f64; 2]) -> [usize; 2] {
        // The cast saturates, and turns NaN into 0.
        let axis = |k: usize| (((p[k] - self.low[k]) * self.scale[k]) as usize).min(self.side - 1);
        [axis(0), axis(1)]
    }
}

/// Twice the signed area of a triangle, positive when counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether an outline of left turns goes round once: its direction enters each half plane once.
fn turns_once(points: &[[f64; 2]]) -> bool {
    let Some(&last) = points.last() else { return false };
    let mut rises = 0;
    let mut was_up = None;
    let mut first_up = None;
    let mut from = last;
    for &to in points {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        from = to;
        let up = dy > 0.0 || (dy == 0.0 && dx > 0.0);
        if was_up == Some(false) && up {
            rises += 1;
        }
        first_up = first_up.or(Some(up));
        was_up = Some(up);
    }
    if was_up == Some(false) && first_up == Some(true) {
        rises += 1;
    }
    rises == 1
}

/// Newell's normal: the sum of the cross products of neighbouring corners, twice the vector area.
///
/// Taken relative to the first corner, so that a polygon far from the origin loses no digits.
fn newell(mut corners: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let Some(origin) = corners.next() else { return sum };
    let mut before = [0.0; 3];
    for p in corners {
        let here = sub(p, origin);
        let c = cross(before, here);
        for k in 0..3 {
            sum[k] += c[k];
        }
        before = here;
    }
    sum
}

fn quad(ids: [u32; 4], p: [[f64; 3]; 4], out: &mut Vec<[u32; 3]>) -> Verdict {
    let [a, b, c, d] = ids;
    let fold = |x: [f64; 3], y: [f64; 3]| dot(x, y);
    let area = |i: usize, j: usize, k: usize| cross(sub(p[j], p[i]), sub(p[k], p[i]));
    let along_ac = fold(area(0, 1, 2), area(0, 2, 3));
    let along_bd = fold(area(0, 1, 3), area(1, 2, 3));
    let (ac, bd) = (sub(p[2], p[0]), sub(p[3], p[1]));
    let shorter_bd = dot(bd, bd) < dot(ac, ac);
    let use_bd = match (along_ac > 0.0, along_bd > 0.0) {
        (true, true) => shorter_bd,
        (true, false) => false,
        (false, true) => true,
        // One triangle is flat or they fold over: the diagonal that folds less.
        (false, false) => along_bd > along_ac,
    };
    if use_bd {
        out.extend([[a, b, d], [b, c, d]]);
    } else {
        out.extend([[a, b, c], [a, c, d]]);
    }
    if along_ac < 0.0 && along_bd < 0.0 { Verdict::SelfCrossing } else { Verdict::Simple }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
#[path = "triangulate_tests.rs"]
mod tests;
