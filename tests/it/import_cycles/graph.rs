//! Which file imports which, and the cycles among them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Files by their paths. An edge has the name that one file imports from the other.
#[derive(Default)]
pub(super) struct Graph(BTreeMap<String, BTreeMap<String, String>>);

impl Graph {
    pub(super) fn add_file(&mut self, file: &str) {
        self.0.entry(file.to_owned()).or_default();
    }

    pub(super) fn add_import(&mut self, from: &str, to: &str, name: &str) {
        if from != to {
            self.add_file(to);
            let imports = self.0.entry(from.to_owned()).or_default();
            imports.entry(to.to_owned()).or_insert(name.to_owned());
        }
    }

    pub(super) fn file_count(&self) -> usize {
        self.0.len()
    }

    /// Returns a shortest cycle of each group of files that import each other, with the imported names.
    pub(super) fn cycles(&self) -> Vec<String> {
        let mut reported = BTreeSet::new();
        let mut cycles = Vec::new();
        for file in self.0.keys() {
            if reported.contains(file.as_str()) {
                continue;
            }
            if let Some(cycle) = self.shortest_cycle(file) {
                reported.extend(cycle.iter().copied());
                cycles.push(self.named(&cycle));
            }
        }
        cycles
    }

    /// Returns the files of a shortest cycle through a file, which is the first and the last of them.
    fn shortest_cycle<'a>(&'a self, file: &'a str) -> Option<Vec<&'a str>> {
        let mut importer = BTreeMap::new();
        let mut queue = VecDeque::from([file]);
        while let Some(from) = queue.pop_front() {
            for to in self.0[from].keys().map(String::as_str) {
                if importer.contains_key(to) {
                    continue;
                }
                importer.insert(to, from);
                queue.push_back(to);
            }
        }
        let mut cycle = vec![file, *importer.get(file)?];
        while cycle[cycle.len() - 1] != file {
            cycle.push(importer[cycle[cycle.len() - 1]]);
        }
        cycle.reverse();
        Some(cycle)
    }

    fn named(&self, cycle: &[&str]) -> String {
        let steps = cycle.windows(2);
        let steps = steps.map(|step| format!("{} -({})-> ", step[0], self.0[step[0]][step[1]]));
        steps.collect::<String>() + cycle[0]
    }
}
