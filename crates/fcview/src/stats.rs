//! Counts and times of frames; the JSON of `--stats`.

use serde::Serialize;

/// Wall-clock milliseconds of the stages of a frame.
///
/// The GPU runs beside the CPU: with [`crate::FrameOptions::measure`] each stage waits for its GPU work and the
/// stages are true; without, GPU time shows in whichever stage waits next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Milliseconds {
    /// Planning the frame, dividing instances into pieces, and cutting those that show, in parallel.
    pub cut: f64,
    /// Handing the triangles to the GPU.
    pub upload: f64,
    /// Drawing the nearest part, which hides the rest.
    pub occluders: f64,
    /// Occlusion queries, with the wait for their answers.
    pub queries: f64,
    /// Drawing what is left of the rest.
    pub draw: f64,
    /// The whole frame, without reading the picture back.
    pub total: f64,
}

/// Counts of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Instances in the scene.
    pub instances: u64,
    /// Instances wholly outside the view.
    pub instances_outside: u64,
    /// Nodes of the trees that the cuts looked at.
    pub nodes_visited: u64,
    /// Nodes left out as outside the view, each with all below it.
    pub nodes_culled_frustum: u64,
    /// Nodes left out as facing away, each with all below it.
    pub nodes_culled_cone: u64,
    /// Clusters drawn, each as one polygon.
    pub clusters: u64,
    /// Triangles of the cut that face against their cluster.
    pub triangles_folded: u64,
    /// Pieces into which the instances that may show were divided; each is asked about, cut and drawn as one.
    pub batches: u64,
    /// Copies and pieces asked about, by occlusion queries or a look at the depth.
    pub queries: u64,
    /// Instances and pieces that the queries found hidden; they are not cut.
    pub batches_culled_occlusion: u64,
    /// Instances among them.
    pub instances_hidden: u64,
    /// Faces of the input below the hidden instances and pieces.
    pub faces_hidden: u64,
    /// Triangles cut and drawn.
    pub triangles_drawn: u64,
}

impl Counts {
    /// Adds what a walk or a cut counted.
    pub(crate) fn add(&mut self, stats: &fcextract::Stats) {
        self.nodes_visited += stats.nodes_visited;
        self.nodes_culled_frustum += stats.culled_frustum;
        self.nodes_culled_cone += stats.culled_cone;
        self.clusters += stats.clusters;
        self.triangles_folded += stats.folded;
    }
}

/// Counts and times of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// Times.
    pub milliseconds: Milliseconds,
    /// Counts.
    pub counts: Counts,
    /// The largest distance bound of a cluster drawn, in the scene's unit: how far its surface may lie from where it
    /// belongs.
    pub bound: f64,
    /// The models' vertices on the GPU.
    pub memory: MemoryStats,
    /// The tolerance in pixels, by the order of budgets, that `--fps` came to; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// What became of a budget of triangles; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<BudgetStats>,
}

/// The models' vertices on the GPU, in pages of 256.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MemoryStats {
    /// Bytes of the memory that they may take: that of all of them, or of a pool of pages.
    pub bytes: u64,
    /// Pages of all models.
    pub pages: u64,
    /// Pages that were there after the frame.
    pub pages_resident: u64,
    /// Pages uploaded during the frame.
    pub pages_uploaded: u64,
    /// Pages that made room for them.
    pub pages_evicted: u64,
    /// By what the tolerance was multiplied, or a number of triangles divided, for the frame's pages to fit: 1 as a
    /// rule, [`COARSEST`] where the coarsest mesh was drawn.
    pub coarser: f64,
}

/// What [`MemoryStats::coarser`] says of the coarsest mesh; smaller factors are tried before it.
pub const COARSEST: f64 = (1 << 24) as f64;

/// A factor on a tolerance in words.
pub(crate) fn coarser_in_words(factor: f64) -> String {
    if factor < COARSEST { format!("{factor:.1} times coarser") } else { "as the coarsest mesh".to_owned() }
}

/// What became of a budget of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BudgetStats {
    /// The budget.
    pub wanted: u64,
    /// Triangles after frustum and cone culling, those that others hide included.
    pub selected: u64,
    /// Whether they keep to the budget; if not, even the coarsest cut is over it.
    pub within: bool,
}

/// What the driver says about itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AdapterStats {
    /// The adapter's name.
    pub name: String,
    /// The driver's name.
    pub driver: String,
    /// The driver's version.
    pub driver_info: String,
    /// Vulkan, Metal, Dx12 or Gl.
    pub backend: String,
    /// DiscreteGpu, IntegratedGpu, VirtualGpu, Cpu or Other.
    pub kind: String,
}

impl From<wgpu::AdapterInfo> for AdapterStats {
    fn from(info: wgpu::AdapterInfo) -> AdapterStats {
        AdapterStats {
            name: info.name,
            driver: info.driver,
            driver_info: info.driver_info,
            backend: format!("{:?}", info.backend),
            kind: format!("{:?}", info.device_type),
        }
    }
}

/// A model of the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelStats {
    /// The file.
    pub name: String,
    /// Its faces at full resolution.
    pub faces: u64,
    /// Its vertices.
    pub vertices: u64,
}

/// The settings of a run, in the words of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingStats {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// Tolerance in pixels; absent at full resolution and with a budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixels: Option<f64>,
    /// `--triangles`; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangles: Option<u64>,
    /// `--fps`; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fps: Option<f64>,
    /// `--gpu-memory`, bytes; absent without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gpu_memory: Option<u64>,
    /// `--no-lod` is off.
    pub lod: bool,
    /// `--no-frustum` is off.
    pub frustum: bool,
    /// `--no-backface` and `--two-sided` are off.
    pub backface: bool,
    /// `--two-sided` is on.
    pub two_sided: bool,
    /// `--occlusion`: `exact` or `off`.
    pub occlusion: &'static str,
    /// `--queries`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queries: Option<u32>,
    /// `--color`: `shaded`, `clusters`, `depth` or `level`.
    pub color: &'static str,
    /// `--wireframe` is on.
    pub wireframe: bool,
    /// `--camera`: `orbit`, `fly` or `path`.
    pub camera: &'static str,
    /// The file of the path; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_path: Option<String>,
    /// `--frames`.
    pub frames: u32,
    /// `--speed`: rounds of the camera.
    pub speed: f64,
    /// Instances placed: those of `--instances`, but at least one of each file.
    pub instances: u64,
    /// `--seed`.
    pub seed: u64,
    /// Vertical field of view, degrees.
    pub fov: f64,
}

/// The whole document. Keys are only ever added; `version` rises if one changes its meaning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunStats {
    /// Version of this document: 2.
    pub version: u32,
    /// The program and its version.
    pub generator: String,
    /// The adapter.
    pub adapter: AdapterStats,
    /// The models.
    pub models: Vec<ModelStats>,
    /// To be added to the scene's coordinates for those of the input; zero where copies stand at random.
    pub origin: [f64; 3],
    /// The settings.
    pub settings: SettingStats,
    /// Milliseconds from the start of the program to the first frame: opening, upload, pipelines.
    pub milliseconds_setup: f64,
    /// The median frame's total, milliseconds; the first frame, which fills buffers, counts only if it is alone.
    pub milliseconds_median: f64,
    /// The frames.
    pub frames: Vec<FrameStats>,
}

/// The median of the frames' totals without the first, milliseconds; 0 for no frames.
pub fn median_total(frames: &[FrameStats]) -> f64 {
    let mut totals: Vec<f64> = frames.iter().map(|frame| frame.milliseconds.total).collect();
    if totals.len() > 1 {
        totals.remove(0);
    }
    totals.sort_by(f64::total_cmp);
    totals.get(totals.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(totals: &[f64]) -> Vec<FrameStats> {
        let frame = |total: &f64| FrameStats {
            milliseconds: Milliseconds { total: *total, ..Default::default() },
            ..Default::default()
        };
        totals.iter().map(frame).collect()
    }

    #[test]
    fn the_median_leaves_out_the_first_of_several_frames() {
        assert_eq!(median_total(&[]), 0.0);
        assert_eq!(median_total(&frames(&[7.0])), 7.0);
        assert_eq!(median_total(&frames(&[100.0, 3.0, 1.0, 2.0])), 2.0);
    }
}
