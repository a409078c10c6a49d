//! The ways to build a tree that the figures compare.

use fcbuild::SplitMode;

/// A mode, and how plots show it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mode {
    /// As the builder takes it.
    pub(crate) split: SplitMode,
    /// What it is, in a few words.
    pub(crate) words: &'static str,
    /// Colour of its curve; these are told apart by most eyes.
    pub(crate) color: &'static str,
    /// Dashes of its curve.
    pub(crate) dashes: &'static str,
}

impl Mode {
    /// The name on the command line.
    pub(crate) fn name(&self) -> &'static str {
        self.split.as_str()
    }

    /// Whether it works from the faces up.
    pub(crate) fn merges(&self) -> bool {
        matches!(self.split, SplitMode::Quality | SplitMode::Merge)
    }
}

/// In the order in which figures show them.
pub(crate) const ALL: &[Mode] = &[
    Mode { split: SplitMode::Pca, words: "PCA alone", color: "#d55e00", dashes: "7 4" },
    Mode { split: SplitMode::Cca, words: "CCA alone", color: "#0072b2", dashes: "2 3" },
    PAPER,
    QUALITY,
    MERGE,
];

/// The paper's own.
pub(crate) const PAPER: Mode =
    Mode { split: SplitMode::Paper, words: "PCA and CCA, the better cut", color: "#009e73", dashes: "" };

/// This project's own, and what the builder does when it is not told.
pub(crate) const QUALITY: Mode = Mode {
    split: SplitMode::Quality,
    words: "merging where the error rises least for each triangle saved",
    color: "#cc3388",
    dashes: "",
};

/// Garland's face clustering, the baseline of `[TsujiJa]`.
pub(crate) const MERGE: Mode = Mode {
    split: SplitMode::Merge,
    words: "merging by flatness, orientation and shape, after Garland",
    color: "#777777",
    dashes: "10 3 2 3",
};
