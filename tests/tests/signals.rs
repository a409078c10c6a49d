//! Promise: a signal ends a command soon, with its code, and leaves nothing behind.

use fctests::commands::{accept, binary, names, sample};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Ctrl-C during the build removes the temporary and ends with 130.
#[cfg(unix)]
#[test]
fn a_signal_stops_the_build_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Sixteen copies make the job long enough to be caught in the middle, however fast the machine is.
    let inputs = vec![sample("sculpture.ply"); 16];
    let mut command = Command::new(binary("fcbuild"));
    command.args(&inputs).args(["-o", "x.fct", "--threads", "1"]).current_dir(folder.path());
    assert_eq!(stopped(command, folder.path(), "INT"), 130);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

/// A terminal that goes away ends the build in the same way, but not one that `nohup` protects.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_goes_away_stops_the_build_unless_it_is_told_not_to() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let status = fs::read_to_string("/proc/self/status").expect("a kernel");
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).expect("a mask");
    let ignored = u64::from_str_radix(ignored.trim(), 16).expect("a mask");
    let inputs = vec![sample("sculpture.ply"); 16];
    let words = ["-o", "x.fct", "--threads", "1"];
    for (signal, exit) in [("HUP", 129), ("QUIT", 131), ("XCPU", 152)] {
        // Where these tests run under `nohup`, the build does too.
        if ignored >> (exit - 129) & 1 == 1 {
            continue;
        }
        let mut command = Command::new(binary("fcbuild"));
        command.args(&inputs).args(words).current_dir(folder.path());
        assert_eq!(stopped(command, folder.path(), signal), exit);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
    let mut command = Command::new("nohup");
    command.arg(binary("fcbuild")).args(&inputs[..2]).args(words).current_dir(folder.path());
    let done = signalled(command, folder.path(), "HUP");
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(names(folder.path()), ["x.fct"]);
}

/// A verification has nothing to leave, and says what ended it.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_stops_a_verification_with_a_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let inputs = ["sculpture.ply", "terrain.ply", "parts.ply"].map(|name| sample(name).display().to_string());
    accept(folder.path(), &format!("fcbuild {} -o a.fct", inputs.join(" ")));
    let mut command = Command::new("nice");
    command.args(["-n", "19"]).arg(binary("fct")).args(["verify", "a.fct"]).current_dir(folder.path());
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the command starts");
    // A signal before the program listens would end it without a word.
    let listens = |process: u32| {
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 2 != 0))
    };
    while !listens(child.id()) {
        assert!(child.try_wait().expect("ours").is_none(), "it ends before it listens");
    }
    send(child.id(), "INT");
    let done = child.wait_with_output().expect("the command ends");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.code() == Some(130) && said.starts_with("error[FC902]"), "{:?} {said}", done.status);
}

/// The same during an export, and for termination.
#[cfg(unix)]
#[test]
fn a_signal_stops_an_export_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    accept(folder.path(), &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    // Searching for a budget takes longest, and a polite process is slow where the machine is busy.
    let mut command = Command::new("nice");
    let line = "export a.fct -o x.obj --triangles 60000";
    command.args(["-n", "19"]).arg(binary("fct")).args(line.split(' ')).current_dir(folder.path());
    assert_eq!(stopped(command, folder.path(), "TERM"), 143);
    assert_eq!(names(folder.path()), ["a.fct"]);
}

/// Starts `command`, sends it the signal once its temporary is there, and gives its exit code.
#[cfg(unix)]
fn stopped(command: Command, folder: &Path, signal: &str) -> i32 {
    let done = signalled(command, folder, signal);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(said.contains("FC902") && said.lines().count() == 1, "{said}");
    done.status.code().unwrap_or(-1)
}

/// Starts `command`, sends it the signal once its temporary is there, and waits for its end.
#[cfg(unix)]
fn signalled(mut command: Command, folder: &Path, signal: &str) -> std::process::Output {
    use std::time::{Duration, Instant};
    let before = names(folder).len();
    let child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the command starts");
    let start = Instant::now();
    while names(folder).len() == before {
        assert!(start.elapsed() < Duration::from_secs(20), "no temporary appears");
        std::thread::sleep(Duration::from_millis(1));
    }
    send(child.id(), signal);
    child.wait_with_output().expect("the command ends")
}

#[cfg(unix)]
fn send(process: u32, signal: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {process}")]).status();
    assert!(sent.is_ok_and(|s| s.success()), "the signal is sent");
}
