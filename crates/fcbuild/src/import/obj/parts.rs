//! What the polygons of an OBJ file belong to: its objects, or, where it has none, its groups.

use std::collections::HashMap;
use std::ops::Range;

use super::super::soup::Group;

/// Statements `o` and `g`, with where they stand.
#[derive(Default)]
pub(super) struct Parts {
    /// Names of the objects, each with the number of polygons before it. One that comes back begins another object.
    objects: Vec<(String, u64)>,
    /// Names of the groups, each once.
    names: Vec<String>,
    number_of: HashMap<String, usize>,
    /// Groups by their number, each with the number of polygons before it. One that comes back goes on.
    groups: Vec<(usize, u64)>,
    /// Groups in an object of another name.
    inside_objects: u64,
}

impl Parts {
    /// Takes an object that begins after so many polygons.
    pub(super) fn object(&mut self, name: String, polygons: u64) {
        self.objects.push((name, polygons));
    }

    /// Takes a group that begins, or goes on, after so many polygons.
    pub(super) fn group(&mut self, name: String, polygons: u64) {
        let is_another = self.objects.last().is_none_or(|(object, _)| *object != name);
        if is_another && !name.is_empty() {
            self.inside_objects = self.inside_objects.saturating_add(1);
        }
        let number = match self.number_of.get(&name) {
            Some(number) => *number,
            None => {
                let number = self.names.len();
                self.names.push(name.clone());
                self.number_of.insert(name, number);
                number
            }
        };
        // Without a polygon in between, the last word counts.
        self.groups.pop_if(|(_, first)| *first == polygons);
        self.groups.push((number, polygons));
    }

    /// How many statements of groups are passed over, because the objects are the groups of the mesh.
    pub(super) fn passed_over(&self) -> u64 {
        if self.objects.is_empty() { 0 } else { self.inside_objects }
    }

    /// Where each part begins: its number, and the number of polygons before it. They come in order.
    pub(super) fn begins(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let of_objects = self.objects.iter().enumerate().map(|(number, (_, first))| (number, *first));
        let of_groups = self.groups.iter().copied().filter(|_| self.objects.is_empty());
        of_objects.chain(of_groups)
    }

    /// The groups of a mesh, each once, and its triangles in their order. `runs` are the triangles of parts, or of no part,
    /// in the order of the file; what has no name of its own is called `stem`.
    pub(super) fn gather(
        &self,
        runs: Vec<(Option<usize>, Range<usize>)>,
        triangles: Vec<[u32; 3]>,
        stem: &str,
    ) -> (Vec<Group>, Vec<[u32; 3]>) {
        let names = if self.objects.is_empty() { self.names.len() } else { self.objects.len() };
        let name = |number: Option<usize>| {
            let given = number.and_then(|number| match self.objects.get(number) {
                Some((name, _)) => Some(name),
                None => self.names.get(number),
            });
            given.filter(|name| !name.is_empty()).map_or(stem, String::as_str)
        };
        // Parts in the order in which they come first, each with its runs.
        let mut place_of = vec![None; names.saturating_add(1)];
        let mut gathered: Vec<(Option<usize>, Vec<Range<usize>>)> = Vec::new();
        for (number, run) in runs.into_iter().filter(|(_, run)| !run.is_empty()) {
            // A group without a name holds what is in no group.
            let key = match number {
                Some(number) if !self.objects.is_empty() || name(Some(number)) != stem => number,
                _ => names,
            };
            let Some(place) = place_of.get_mut(key) else { continue };
            let place = *place.get_or_insert(gathered.len());
            match gathered.get_mut(place) {
                Some((_, runs)) => runs.push(run),
                None => gathered.push((number, vec![run])),
            }
        }
        let comes_back = gathered.iter().any(|(_, runs)| runs.len() > 1);
        let mut sorted = Vec::with_capacity(if comes_back { triangles.len() } else { 0 });
        let mut groups = Vec::with_capacity(gathered.len());
        let mut start = 0_usize;
        for (number, runs) in gathered {
            let count = runs.iter().fold(0_usize, |sum, run| sum.saturating_add(run.len()));
            let end = start.saturating_add(count);
            groups.push(Group { name: name(number).to_owned(), triangles: start..end });
            start = end;
            if comes_back {
                runs.into_iter().for_each(|run| sorted.extend(triangles.get(run).unwrap_or_default()));
            }
        }
        (groups, if comes_back { sorted } else { triangles })
    }
}
