//! Promise: the command's exit codes, messages and documents.

mod model;

use std::path::Path;
use std::process::{Command, Output};

fn fcview(folder: &Path, words: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
    command.current_dir(folder).args(words.split_whitespace());
    // No display, so that a window cannot open by chance.
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.output().expect("fcview runs")
}

fn refused(output: &Output, code: i32, parts: &[&str]) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(output.stdout.is_empty(), "errors go to stderr alone");
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    model::write_torus(&folder.path().join("torus.fct"), 48, 24);
    folder
}

/// A device that is always full, where there is one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_told() {
    model::gpu();
    let folder = folder();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
    command.current_dir(folder.path()).args(["torus.fct", "--headless", "--size", "64x48"]).stdout(full);
    refused(&command.output().expect("fcview runs"), 4, &["error[FC413]", "cannot write to standard output"]);
}

#[test]
fn pictures_and_stats_are_written() {
    model::gpu();
    let folder = folder();
    let words =
        "torus.fct --headless --instances 4 --size 96x64 --frames 3 --screenshot a{n}.png --stats s.json";
    let output = fcview(folder.path(), words);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("wrote a2.png") && said.contains("wrote s.json"), "{said}");
    for n in 0..3 {
        let file = std::fs::File::open(folder.path().join(format!("a{n}.png"))).unwrap();
        let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (96, 64));
    }
    let text = std::fs::read_to_string(folder.path().join("s.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(stats["version"], 2);
    assert_eq!(stats["settings"]["seed"], 1);
    assert_eq!(stats["origin"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(stats["models"][0]["faces"], 2 * 48 * 24);
    assert_eq!(stats["frames"].as_array().unwrap().len(), 3);
    for (n, frame) in stats["frames"].as_array().unwrap().iter().enumerate() {
        assert_eq!(frame["frame"], n);
        for key in ["cut", "upload", "occluders", "queries", "draw", "total"] {
            assert!(frame["milliseconds"][key].as_f64().unwrap() >= 0.0);
        }
        let counts = &frame["counts"];
        assert_eq!(counts["instances"], 4);
        assert!(counts["triangles_drawn"].as_u64().unwrap() > 0);
    }
    assert!(!stats["adapter"]["name"].as_str().unwrap().is_empty());
}

#[test]
fn without_a_placeholder_only_the_last_frame_is_kept() {
    model::gpu();
    let folder = folder();
    let output = fcview(folder.path(), "torus.fct --headless --size 32x32 --frames 2 --screenshot only.png");
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stdout).matches("wrote").count(), 1);
}

#[test]
fn odd_input_has_its_exit_code_and_names_the_file() {
    let folder = folder();
    std::fs::write(folder.path().join("mesh.ply"), "ply\nformat ascii 1.0\n").unwrap();
    std::fs::write(folder.path().join("empty.fct"), "").unwrap();
    refused(&fcview(folder.path(), "mesh.ply --headless"), 7, &["error[FC", "mesh.ply", "fcbuild"]);
    refused(&fcview(folder.path(), "empty.fct --headless"), 7, &["error[FC", "empty.fct"]);
    refused(&fcview(folder.path(), "gone.fct --headless"), 4, &["error[FC", "gone.fct"]);
    refused(&fcview(folder.path(), ". --headless"), 4, &["error[FC"]);
    refused(&fcview(folder.path(), "torus.fct --headless --pixels -1"), 2, &["--pixels"]);
    refused(&fcview(folder.path(), ""), 2, &["FILE.fct"]);
}

/// One changed byte, wherever it is, is told before anything is drawn.
#[test]
fn a_damaged_file_is_told_and_not_drawn() {
    let folder = folder();
    let sound = std::fs::read(folder.path().join("torus.fct")).unwrap();
    for part in 0..24 {
        let mut damaged = sound.clone();
        let at = (sound.len() - 1) * part / 23;
        damaged[at] ^= 0x10;
        std::fs::write(folder.path().join("hurt.fct"), &damaged).unwrap();
        let output = fcview(folder.path(), "hurt.fct --headless --size 32x32 --screenshot hurt.png");
        refused(&output, 7, &["error[FC", "hurt.fct"]);
        assert!(!folder.path().join("hurt.png").exists(), "byte {at}");
    }
    let cut = sound.len() / 2;
    std::fs::write(folder.path().join("hurt.fct"), &sound[..cut]).unwrap();
    refused(&fcview(folder.path(), "hurt.fct torus.fct --headless"), 7, &["error[FC", "hurt.fct"]);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    model::gpu();
    let folder = folder();
    for words in ["--screenshot no/such/a.png", "--stats no/such/s.json"] {
        let words = format!("torus.fct --headless --size 32x32 {words}");
        refused(&fcview(folder.path(), &words), 4, &["error[FC423]", "no/such/"]);
    }
    // Not even the administrator can make files among those of the kernel.
    if Path::new("/proc/self").is_dir() {
        for words in ["--screenshot /proc/a.png", "--stats /proc/s.json"] {
            let said = fcview(folder.path(), &format!("torus.fct --headless --size 32x32 {words}"));
            refused(&said, 4, &["error[FC423]: /proc/", "choose a folder"]);
            assert!(!String::from_utf8_lossy(&said.stderr).contains("tmp"), "the temporary is not named");
        }
    }
}

#[test]
fn an_output_never_replaces_an_input_or_the_other_output() {
    let folder = folder();
    let torus = folder.path().join("torus.fct");
    let before = std::fs::read(&torus).unwrap();
    for name in ["linked.png", "7.png"] {
        std::fs::hard_link(&torus, folder.path().join(name)).unwrap();
    }
    for outputs in [
        "--stats torus.fct",
        "--stats ./torus.fct",
        "--screenshot linked.png",
        "--frames 9 --screenshot {n}.png",
        "--screenshot new.png --stats ./new.png",
    ] {
        let output = fcview(folder.path(), &format!("torus.fct --headless --size 32x32 {outputs}"));
        refused(&output, 2, &["error[FC101]", "another name"]);
    }
    assert!(std::fs::read(&torus).unwrap() == before, "the input has changed");
    assert!(!folder.path().join("new.png").exists());
}

#[test]
fn outputs_are_refused_before_anything_is_drawn() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("sub.png")).unwrap();
    std::fs::write(folder.path().join("way.json"), "{\"version\": 1, \"keys\": []}").unwrap();
    for (outputs, code, part) in [
        ("--screenshot a.jpg", 2, ".png"),
        ("--screenshot a", 2, ".png"),
        ("--screenshot -", 2, "standard output"),
        ("--stats -", 2, "standard output"),
        ("--stats scan.ply", 2, ".json"),
        ("--stats way.json", 4, "no stats document"),
        ("--screenshot a{n.png", 2, "{n}"),
        ("--screenshot a{m}.png", 2, "{n}"),
        ("--screenshot sub.png", 4, "regular file"),
        ("--stats .", 4, "regular file"),
        ("--screenshot none/a.png", 4, "folder none"),
        ("--stats torus.fct/s.json", 4, "folder torus.fct"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
        // No driver: a run that gets as far as the device fails by that.
        command.env("WGPU_BACKEND", "none").current_dir(folder.path());
        command.args(["torus.fct", "--headless"]).args(outputs.split_whitespace());
        refused(&command.output().unwrap(), code, &["error[FC", part]);
    }
}

#[test]
fn existing_pictures_are_replaced_and_nothing_else_is_left() {
    model::gpu();
    let folder = folder();
    std::fs::write(folder.path().join("a.png"), "old").unwrap();
    // What a killed run has left.
    let left = std::fs::File::create(folder.path().join(".fcview-output.x.fct-tmp")).unwrap();
    left.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(120)).unwrap();
    drop(left);
    for _ in 0..2 {
        let output =
            fcview(folder.path(), "torus.fct --headless --size 32x32 --screenshot a.png --stats s.json");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(said.contains("1 frame,") && said.contains("1 instance)"), "{said}");
    }
    assert!(std::fs::read(folder.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "the model and the outputs");
}

#[test]
fn several_files_stand_where_they_are_and_each_is_shown() {
    model::gpu();
    let folder = folder();
    std::fs::copy(folder.path().join("torus.fct"), folder.path().join("twin.fct")).unwrap();
    let stats = |words: &str| -> serde_json::Value {
        let words = format!("{words} --headless --size 64x48 --stats s.json --color clusters");
        assert!(fcview(folder.path(), &words).status.success(), "{words}");
        serde_json::from_slice(&std::fs::read(folder.path().join("s.json")).unwrap()).unwrap()
    };
    let together = stats("torus.fct twin.fct");
    assert_eq!(together["settings"]["instances"], 2);
    assert_eq!(together["settings"]["color"], "clusters");
    assert_eq!(together["settings"]["camera"], "orbit");
    assert_eq!(together["settings"]["frames"], 1);
    assert_eq!(together["settings"]["two_sided"], false);
    // Twins in one place are seen as one alone is, so each has the same cut.
    let selected = |stats: &serde_json::Value| stats["frames"][0]["counts"]["triangles_drawn"].as_u64();
    assert_eq!(selected(&together), selected(&stats("torus.fct")).map(|alone| 2 * alone));
    assert_eq!(stats("torus.fct twin.fct --instances 1")["settings"]["instances"], 2);
}

#[test]
fn a_backend_that_is_not_there_and_an_adapter_that_is_not_there_are_said() {
    let folder = folder();
    let run = |name: &str, value: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
        command.current_dir(folder.path()).args(["torus.fct", "--headless"]).env(name, value);
        command.output().unwrap()
    };
    let backend = if cfg!(target_os = "macos") { "dx12" } else { "metal" };
    refused(&run("WGPU_BACKEND", backend), 6, &["error[FC609]", "WGPU_BACKEND", backend, "unset"]);
    refused(&run("WGPU_BACKEND", "foo"), 6, &["error[FC609]", "foo", "give one of: ", "unset"]);
    model::gpu();
    refused(&run("WGPU_ADAPTER_NAME", "no such card"), 6, &["error[FC602]", "no such card", "unset"]);
}

#[test]
fn without_an_adapter_the_backends_are_named() {
    let folder = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
    command.current_dir(folder.path()).args(["torus.fct", "--headless"]);
    // Backends without any driver.
    command
        .env_remove("WGPU_BACKEND")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent");
    if cfg!(target_os = "linux") {
        let start = std::time::Instant::now();
        refused(&command.output().unwrap(), 6, &["error[FC601]", "vulkan", "mesa-vulkan-drivers"]);
        assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
        command.env("WGPU_BACKEND", "vulkan");
        refused(&command.output().unwrap(), 6, &["error[FC609]", "vulkan", "mesa-vulkan-drivers"]);
    }
}

#[test]
fn a_recorded_path_is_followed_from_its_first_key_to_its_last() {
    model::gpu();
    let folder = folder();
    let key = |seconds: f64, x: f64| {
        format!(r#"{{"seconds":{seconds},"eye":[{x},0,6],"forward":[0,0,-1],"up":[0,1,0],"fov":40}}"#)
    };
    let write = |name: &str, keys: &[String]| {
        let text = format!(r#"{{"version":1,"keys":[{}]}}"#, keys.join(","));
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("way.json", &[key(2.0, -1.0), key(3.0, 0.5), key(7.0, 1.0)]);
    write("first.json", &[key(0.0, -1.0)]);
    write("last.json", &[key(0.0, 1.0)]);
    let run = |words: &str| {
        let output = fcview(folder.path(), &format!("torus.fct --headless --size 64x48 {words}"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run("--camera way.json --frames 4 --screenshot f{n}.png --stats s.json");
    run("--camera first.json --screenshot first.png");
    run("--camera last.json --screenshot last.png");
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("f0.png") == bytes("first.png") && bytes("f3.png") == bytes("last.png"));
    assert!(bytes("f1.png") != bytes("f0.png") && bytes("f1.png") != bytes("f3.png"));
    let stats: serde_json::Value = serde_json::from_slice(&bytes("s.json")).unwrap();
    assert_eq!(stats["settings"]["camera"], "path");
    assert_eq!(stats["settings"]["camera_path"], "way.json");

    write("none.json", &[]);
    refused(
        &fcview(folder.path(), "torus.fct --headless --camera none.json"),
        3,
        &["error[FC224]", "none.json"],
    );
    refused(
        &fcview(folder.path(), "torus.fct --headless --camera gone.json"),
        4,
        &["error[FC424]", "gone.json"],
    );
    let over = "torus.fct --headless --camera way.json --stats way.json";
    refused(&fcview(folder.path(), over), 2, &["error[FC101]", "an input"]);
}

/// The command, which ignores no signal, also where these tests run in the background of a script.
#[cfg(unix)]
fn listening() -> Command {
    if !cfg!(target_os = "linux") {
        return Command::new(env!("CARGO_BIN_EXE_fcview"));
    }
    let mut command = Command::new("env");
    command.args(["--default-signal=INT,TERM", env!("CARGO_BIN_EXE_fcview")]);
    command
}

/// A terminal's Ctrl-C ends the run with a message, and leaves whole pictures alone.
#[cfg(unix)]
#[test]
fn a_signal_stops_a_long_run_and_leaves_no_temporary() {
    use std::os::unix::process::ExitStatusExt as _;
    model::gpu();
    let folder = folder();
    let mut command = listening();
    let words = "torus.fct --headless --size 320x240 --frames 100000 --screenshot f{n}.png --stats s.json";
    command.current_dir(folder.path()).args(words.split_whitespace());
    let child =
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let start = std::time::Instant::now();
    while !folder.path().join("f00001.png").exists() {
        assert!(start.elapsed().as_secs() < 60, "no picture appears");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
    assert!(sent.unwrap().success());
    let done = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.signal(), Some(2), "{said}");
    assert!(said.contains("error[FC902]") && said.contains("of 100000 frames"), "{said}");
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(name == "torus.fct" || name.ends_with(".png") && !name.starts_with('.'), "{name}");
    }
}

/// A frame of so many copies takes far longer than anybody waits who has pressed Ctrl-C.
#[cfg(unix)]
#[test]
fn a_signal_stops_a_long_frame_at_once() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::time::{Duration, Instant};
    model::gpu();
    let folder = folder();
    for (signal, number) in [("INT", 2), ("TERM", 15)] {
        let mut command = listening();
        let words =
            "torus.fct --headless --size 64x48 --instances 1000000 --triangles 100000000 --screenshot f.png";
        command.current_dir(folder.path()).args(words.split_whitespace());
        let mut child =
            command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_secs(3));
        assert!(child.try_wait().unwrap().is_none(), "the frame is too short for this test");
        let start = Instant::now();
        let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status();
        assert!(sent.unwrap().success());
        let done = child.wait_with_output().unwrap();
        let (said, took) = (String::from_utf8_lossy(&done.stderr), start.elapsed());
        assert_eq!(done.status.signal(), Some(number), "{said}");
        assert!(said.contains("error[FC902]") && said.contains("0 of 1 frames"), "{said}");
        assert!(took < Duration::from_secs(3), "{took:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no picture and no temporary");
    }
}

#[test]
fn a_model_that_looks_inwards_is_told() {
    model::gpu();
    let folder = folder();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(glam::Vec3::from);
    let outwards = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let inwards = outwards.map(|[a, b, c]| [a, c, b]);
    for (name, faces) in [("out.fct", outwards), ("in.fct", inwards)] {
        model::write(&folder.path().join(name), &corners, faces.to_vec());
    }
    for (words, told) in
        [("out.fct", false), ("torus.fct", false), ("in.fct", true), ("in.fct --two-sided", false)]
    {
        let output = fcview(folder.path(), &format!("{words} --headless --size 32x32"));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains("--two-sided"), told, "{words}: {said}");
    }
}

/// The names of all members of a document: with dots for members of members, from anew in the elements of a list.
fn members(document: &serde_json::Value, above: &str, names: &mut Vec<String>) {
    match document {
        serde_json::Value::Object(map) => {
            for (name, value) in map {
                names.push(format!("{above}{name}"));
                members(value, &format!("{above}{name}."), names);
            }
        }
        serde_json::Value::Array(list) if list.iter().all(serde_json::Value::is_object) => {
            list.iter().take(1).for_each(|value| members(value, "", names));
        }
        _ => {}
    }
}

#[test]
fn every_member_of_the_stats_is_in_the_documentation() {
    model::gpu();
    let folder = folder();
    let words = "torus.fct --headless --size 32x32 --stats s.json";
    assert!(fcview(folder.path(), words).status.success());
    let text = std::fs::read_to_string(folder.path().join("s.json")).unwrap();
    let mut names = Vec::new();
    members(&serde_json::from_str(&text).unwrap(), "", &mut names);
    assert!(names.len() > 30, "{names:?}");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/viewer.md");
    let page = std::fs::read_to_string(page).unwrap();
    let missing: Vec<_> = names.iter().filter(|name| !page.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "docs/viewer.md does not describe: {missing:?}");
}

#[test]
fn messages_for_programs_are_an_object_a_line() {
    model::gpu();
    let folder = folder();
    let lines = |words: &str| -> Vec<serde_json::Value> {
        let output = fcview(folder.path(), &format!("{words} --message-format json"));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        // A driver may write lines of its own.
        said.lines()
            .filter(|line| line.starts_with('{'))
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    };
    let warnings = lines("torus.fct --headless --size 64x48 --frames 2 --triangles 1");
    let of_budget = warnings.iter().find(|warning| warning["code"] == "FC591").unwrap();
    assert_eq!((&of_budget["level"], &of_budget["name"]), (&"warning".into(), &"over_budget".into()));
    for (words, code, exit) in [("none.fct --headless", "FC471", 4), ("torus.fct --frames none", "FC100", 2)]
    {
        let errors = lines(words);
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert_eq!((&errors[0]["code"], &errors[0]["exit"]), (&code.into(), &exit.into()), "{errors:?}");
    }
}

#[test]
fn a_budget_below_the_coarsest_mesh_is_said_once() {
    model::gpu();
    let folder = folder();
    for (triangles, over) in [(1, true), (2000, false)] {
        let words = format!("torus.fct --headless --size 64x48 --frames 3 --triangles {triangles}");
        let output = fcview(folder.path(), &words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches("the coarsest meshes of 3 frames").count(), usize::from(over), "{said}");
    }
}

#[test]
fn too_little_memory_for_vertices_is_said_once_or_refused() {
    model::gpu();
    let folder = folder();
    let run = |words: &str| {
        let words =
            format!("torus.fct --headless --size 64x48 --frames 3 --stats s.json --gpu-memory {words}");
        fcview(folder.path(), &words)
    };
    let warning = "--gpu-memory does not hold the vertices of 3 frames";
    for (size, short) in [("15K", true), ("1G", false)] {
        let output = run(size);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(said.matches(warning).count(), usize::from(short), "{said}");
        assert_eq!(said.matches("as the coarsest mesh; allow more").count(), usize::from(short), "{said}");
        let text = std::fs::read_to_string(folder.path().join("s.json")).unwrap();
        let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
        let factor = stats["frames"][2]["memory"]["coarser"].as_f64().unwrap();
        assert_eq!(factor, if short { 16_777_216.0 } else { 1.0 });
        assert!(stats["settings"]["gpu_memory"].as_u64().is_some());
    }
    refused(&run("14K"), 5, &["error[FC524]", "15360"]);
    refused(&run("much"), 2, &["800M"]);
}

#[test]
fn a_run_survives_three_losses_of_the_device_and_ends_at_the_fourth() {
    model::gpu();
    let folder = folder();
    let run = |words: &str| {
        fcview(folder.path(), &format!("torus.fct --headless --size 64x48 --frames 2 --screenshot {words}"))
    };
    assert!(run("whole.png").status.success());
    let survived = run("mended.png --lose-device 3");
    assert!(survived.status.success(), "{}", String::from_utf8_lossy(&survived.stderr));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("whole.png") == bytes("mended.png"), "the picture has changed");
    refused(&run("none.png --lose-device 4"), 6, &["error[FC605]", "three times"]);
    // Without memory a frame is drawn once more.
    assert!(run("less.png --exhaust-memory 1").status.success());
    assert!(bytes("whole.png") == bytes("less.png"), "the picture has changed");
    refused(&run("none.png --exhaust-memory 2"), 5, &["error[FC525]", "--pixels"]);
}

#[test]
fn without_a_display_the_window_says_so() {
    let folder = folder();
    if cfg!(target_os = "linux") {
        refused(&fcview(folder.path(), "torus.fct"), 6, &["error[FC608]", "--headless"]);
    }
}

#[test]
fn help_shows_examples_on_stdout() {
    let folder = tempfile::tempdir().unwrap();
    let output = fcview(folder.path(), "--help");
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("--instances 100") && text.contains("Exit codes"), "{text}");
    for part in ["replaced", "Shift", "wheel", "W A S D", "Esc"] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}
