//! The list to open another file from.

use egui::{Align2, Context, Key, RichText, ScrollArea};
use fct::grouped;
use std::path::{Path, PathBuf};

/// The most entries that are listed; who has more types the name.
const MOST: usize = 2000;

/// A folder's contents, to choose from.
pub(super) struct Chooser {
    pub(super) open: bool,
    folder: PathBuf,
    text: String,
    /// Names of folders, with a slash, and of trees, with their size.
    entries: Vec<(String, Option<u64>)>,
    trouble: Option<String>,
    /// Whether it was just opened, and the text has to take the keyboard.
    fresh: bool,
}

impl Chooser {
    /// Begins in the folder of a file.
    pub(super) fn beside(file: Option<&PathBuf>) -> Chooser {
        let folder = file.and_then(|file| file.parent()).filter(|folder| !folder.as_os_str().is_empty());
        Chooser {
            open: false,
            folder: folder.unwrap_or(Path::new(".")).to_path_buf(),
            text: String::new(),
            entries: Vec::new(),
            trouble: None,
            fresh: false,
        }
    }

    /// Opens or closes it.
    pub(super) fn toggle(&mut self) {
        self.open = !self.open;
        if self.open {
            self.fresh = true;
            self.list(self.folder.clone());
        }
    }

    /// Lays it out where it is open. Returns a file that was chosen.
    pub(super) fn show(&mut self, context: &Context) -> Option<PathBuf> {
        if !self.open {
            return None;
        }
        let mut chosen = None;
        let mut keep = true;
        egui::Window::new("Open a tree")
            .open(&mut keep)
            .collapsible(false)
            .resizable(false)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(context, |ui| {
                ui.set_width(360.0);
                let text = egui::TextEdit::singleline(&mut self.text)
                    .hint_text("file or folder; Enter opens it")
                    .desired_width(f32::INFINITY);
                let response = ui.add(text);
                if std::mem::take(&mut self.fresh) {
                    response.request_focus();
                }
                if response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                    chosen = Some(self.text.trim().to_owned());
                }
                if let Some(trouble) = &self.trouble {
                    ui.colored_label(ui.visuals().error_fg_color, trouble);
                }
                ui.label(RichText::new(self.folder.display().to_string()).small().weak());
                ScrollArea::vertical().max_height(260.0).auto_shrink([false, false]).show(ui, |ui| {
                    for (name, bytes) in &self.entries {
                        ui.horizontal(|ui| {
                            if ui.selectable_label(false, name).clicked() {
                                chosen = Some(name.clone());
                            }
                            if let Some(bytes) = bytes {
                                let size = format!("{} kB", grouped(bytes.div_ceil(1000)));
                                ui.label(RichText::new(size).small().weak());
                            }
                        });
                    }
                });
            });
        self.open &= keep;
        let path = self.folder.join(chosen.filter(|text| !text.is_empty())?);
        if path.is_dir() {
            self.text.clear();
            self.fresh = true;
            self.list(path);
            return None;
        }
        Some(path)
    }

    /// A file that was chosen was opened, or could not be.
    pub(super) fn done(&mut self, result: Result<(), String>) {
        match result {
            Ok(()) => {
                self.open = false;
                self.text.clear();
            }
            Err(trouble) => {
                self.trouble = Some(trouble);
                self.fresh = true;
            }
        }
    }

    /// Goes to a folder.
    fn list(&mut self, folder: PathBuf) {
        match entries(&folder) {
            Ok(entries) => {
                self.entries = entries;
                self.trouble = None;
                // Without the dots that going up and down would pile up.
                self.folder = folder.canonicalize().unwrap_or(folder);
            }
            Err(error) => self.trouble = Some(format!("{}: {error}", folder.display())),
        }
    }
}

/// The way up, the folders, then the trees of a folder, each sorted by name.
fn entries(folder: &Path) -> std::io::Result<Vec<(String, Option<u64>)>> {
    let (mut folders, mut trees) = (Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder)?.flatten().take(MOST) {
        // Names that are not Unicode cannot be typed either; they can be dropped on the window.
        let Ok(name) = entry.file_name().into_string() else { continue };
        let Ok(found) = std::fs::metadata(entry.path()) else { continue };
        if found.is_dir() && !name.starts_with('.') {
            folders.push((name + "/", None));
        } else if found.is_file() && name.to_lowercase().ends_with(".fct") {
            trees.push((name, Some(found.len())));
        }
    }
    folders.sort();
    trees.sort();
    Ok(std::iter::once(("../".to_owned(), None)).chain(folders).chain(trees).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_come_first_and_only_trees_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.fct", "A.FCT", "notes.txt", ".hidden.fct"] {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        std::fs::create_dir(folder.path().join(".git")).unwrap();
        let names: Vec<_> = entries(folder.path()).unwrap().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["../", "sub/", ".hidden.fct", "A.FCT", "b.fct"]);
        assert!(entries(&folder.path().join("none")).is_err());
    }

    #[test]
    fn a_folder_that_is_gone_keeps_the_list() {
        let folder = tempfile::tempdir().unwrap();
        let mut chooser = Chooser::beside(Some(&folder.path().join("a.fct")));
        chooser.toggle();
        assert!(chooser.open && chooser.trouble.is_none() && chooser.entries.len() == 1);
        chooser.list(folder.path().join("gone"));
        assert!(chooser.trouble.is_some() && chooser.entries.len() == 1);
    }
}
