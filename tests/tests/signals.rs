//! Promise: a signal ends a command soon, as a shell expects it, and leaves nothing behind.
#![cfg(unix)]

use fctests::commands::{accept, binary, names, sample};
use std::fs;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

/// Signals that end a command, with their numbers.
const SIGNALS: [(&str, i32); 5] = [("INT", 2), ("TERM", 15), ("HUP", 1), ("QUIT", 3), ("XCPU", 24)];

/// A build is stopped by each of them: it removes the temporary and dies by the signal, without a dump of its memory.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_stops_the_build_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (signal, number) in SIGNALS {
        let mut command = listening("sh");
        // Dumps are allowed as far as the system allows it to allow them.
        command.args(["-c", "ulimit -S -c $(ulimit -H -c); exec \"$0\" \"$@\""]).arg(binary("fcbuild"));
        command.args(long_build()).current_dir(folder.path());
        let status = stopped(command, folder.path(), signal);
        assert!(status.signal() == Some(number) && !status.core_dumped(), "{signal}: {status:?}");
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}

/// `timeout` sends a signal to the command and to its group, and people press Ctrl-C twice.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_comes_twice_leaves_nothing_either() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for between in [0, 1, 5] {
        let mut command = listening(binary("fcbuild"));
        command.args(long_build()).current_dir(folder.path()).stderr(Stdio::piped());
        let child = started(command, folder.path());
        send(child.id().into(), "INT");
        std::thread::sleep(Duration::from_millis(between));
        // The first one may have ended it by now.
        let _ =
            Command::new("kill").args(["-s", "INT", &child.id().to_string()]).stderr(Stdio::null()).status();
        let done = child.wait_with_output().expect("the command ends");
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.signal() == Some(2) && said.contains("[FC902]"), "{between}: {said}");
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}

/// A shell stops with a command that Ctrl-C has stopped, also in the middle of a loop.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_stops_a_loop() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = listening("bash");
    let script = "for i in 1 2 3; do echo round $i; \"$0\" \"$@\"; done";
    command.args(["-c", script]).arg(binary("fcbuild")).args(long_build());
    // The terminal's Ctrl-C goes to the shell and its command.
    command.current_dir(folder.path()).process_group(0);
    let child = started(command, folder.path());
    send(-i64::from(child.id()), "INT");
    let done = child.wait_with_output().expect("the shell ends");
    assert_eq!((String::from_utf8_lossy(&done.stdout).trim(), done.status.signal()), ("round 1", Some(2)));
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

/// In the background of a shell without job control Ctrl-C is for others, and under `nohup` a terminal may go away.
#[test]
fn a_signal_that_is_ignored_stays_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (signal, _) in SIGNALS {
        let mut command = Command::new("sh");
        command.args(["-c", &format!("trap '' {signal}; exec \"$0\" \"$@\"")]).arg(binary("fcbuild"));
        command.arg(sample("sculpture.ply")).args(["-o", "x.fct", "--force"]).current_dir(folder.path());
        let child = started(command, folder.path());
        send(child.id().into(), signal);
        let done = child.wait_with_output().expect("the command ends");
        assert_eq!(done.status.code(), Some(0), "{signal}: {}", String::from_utf8_lossy(&done.stderr));
        assert_eq!(names(folder.path()), ["x.fct"]);
        fs::remove_file(folder.path().join("x.fct")).expect("it is there");
    }
}

/// A verification has nothing to leave, and says what ended it.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_stops_a_verification_with_a_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let inputs = ["sculpture.ply", "terrain.ply", "parts.ply"].map(|name| sample(name).display().to_string());
    accept(folder.path(), &format!("fcbuild {} -o a.fct", inputs.join(" ")));
    let mut command = listening("nice");
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
    send(child.id().into(), "INT");
    let done = child.wait_with_output().expect("the command ends");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.signal() == Some(2) && said.starts_with("error[FC902]"), "{:?} {said}", done.status);
}

/// The same during an export, and for termination.
#[test]
fn a_signal_stops_an_export_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    accept(folder.path(), &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    // Searching for a budget takes longest, and a polite process is slow where the machine is busy.
    let mut command = Command::new("nice");
    let line = "export a.fct -o x.obj --triangles 60000";
    command.args(["-n", "19"]).arg(binary("fct")).args(line.split(' ')).current_dir(folder.path());
    let status = stopped(command, folder.path(), "TERM");
    assert_eq!(status.signal(), Some(15), "{status:?}");
    assert_eq!(names(folder.path()), ["a.fct"]);
}

/// Words for `fcbuild`: sixteen copies make the job long enough to be caught in the middle, however fast the machine is.
fn long_build() -> Vec<std::ffi::OsString> {
    let inputs = vec![sample("sculpture.ply").into_os_string(); 16];
    inputs.into_iter().chain(["-o", "x.fct", "--threads", "1"].map(Into::into)).collect()
}

/// A command that ignores no signal, also where these tests run under `nohup` or in the background of a script.
#[cfg(target_os = "linux")]
fn listening(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new("env");
    command.arg("--default-signal=INT,TERM,HUP,QUIT,XCPU").arg(program);
    command
}

/// Starts `command`, sends it the signal once its temporary is there, and says how it ended.
fn stopped(command: Command, folder: &Path, signal: &str) -> ExitStatus {
    let child = started(command, folder);
    send(child.id().into(), signal);
    let Output { status, stderr, .. } = child.wait_with_output().expect("the command ends");
    let said = String::from_utf8_lossy(&stderr);
    assert!(said.contains("error[FC902]: stopped by a signal; nothing was written"), "{signal}: {said}");
    assert_eq!(said.lines().count(), 1, "{signal}: {said}");
    status
}

/// Starts `command` and waits for its temporary.
fn started(mut command: Command, folder: &Path) -> Child {
    let before = names(folder).len();
    let child = command.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the command starts");
    let start = Instant::now();
    while names(folder).len() == before {
        assert!(start.elapsed() < Duration::from_secs(20), "no temporary appears");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

/// Sends a signal to a process, or to the group of which it is the negative number.
fn send(process: i64, signal: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -s {signal} -- {process}")]).status();
    assert!(sent.is_ok_and(|s| s.success()), "the signal is sent");
}
