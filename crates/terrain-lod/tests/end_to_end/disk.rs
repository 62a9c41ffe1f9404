//! Disks that are full or read-only: the path is named, and nothing is shown as complete.

use std::path::Path;
use std::process::{Command, Output};

/// Runs a small bench under a shell's preparations, with the program as `$0`.
fn bench_after(place: &Path, preparations: &str) -> Output {
    let script = format!("{preparations} exec \"$0\" bench --no-gpu --suite smoke --out results");
    Command::new("sh").current_dir(place).args(["-c", &script, env!("CARGO_BIN_EXE_terrain-lod")]).output().unwrap()
}

fn check(output: &Output, place: &Path, what: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(6), "{what}: {said}");
    assert!(said.starts_with("error: cannot write results") && said.lines().count() == 1, "{what}: {said}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{what} printed results");
    let results = place.join("results");
    let is_empty = std::fs::read_dir(&results).map_or(true, |mut entries| entries.next().is_none());
    assert!(is_empty || results.join("INCOMPLETE").exists(), "{what} looks complete");
}

/// A limit on the size of files refuses the write that crosses it, as a full disk does, and needs no rights.
#[test]
fn a_write_that_is_refused_ends_the_bench_wherever_it_comes() {
    for blocks in [0, 1, 4, 8, 12, 24] {
        let place = tempfile::tempdir().unwrap();
        let limit = format!("trap '' XFSZ; ulimit -f {blocks};");
        check(&bench_after(place.path(), &limit), place.path(), &format!("files of {blocks} blocks"));
    }
}

/// A disk of a few pages in a namespace of its own, where the system lets us make one.
#[test]
fn a_full_disk_ends_the_bench_and_what_was_done_goes_on_elsewhere() {
    for kib in [4, 16, 32, 64] {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join("disk")).unwrap();
        let mount = format!("mount -t tmpfs -o size={kib}k none disk && cd disk && ");
        // The copy lets us see after the disk is gone.
        let script = format!(
            "{mount} {{ \"$0\" bench --no-gpu --suite smoke --out results; code=$?; cp -r results ..; exit $code; }}"
        );
        let Some(output) = in_namespace(place.path(), &script) else { return };
        check(&output, place.path(), &format!("a disk of {kib} KiB"));
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_anything_is_flown() {
    let place = tempfile::tempdir().unwrap();
    let output = bench_after(place.path(), "chmod 555 .;");
    let is_root = place.path().join("results").exists();
    if is_root {
        return eprintln!("skipped: this user may write everywhere");
    }
    check(&output, place.path(), "a read-only folder");
}

/// Runs a script in a namespace of its own, where it may mount disks; `None` where the system does not let us.
fn in_namespace(place: &Path, script: &str) -> Option<Output> {
    let arguments = ["-rm", "sh", "-c", script, env!("CARGO_BIN_EXE_terrain-lod")];
    let output = Command::new("unshare").current_dir(place).args(arguments).output().ok()?;
    let said = String::from_utf8_lossy(&output.stderr);
    if said.contains("unshare:") || said.contains("mount:") {
        eprintln!("skipped: cannot mount a disk: {said}");
        return None;
    }
    Some(output)
}

fn refused(output: &Output, expected: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), said.lines().count()), (Some(6), 1), "{said}");
    assert!(said.starts_with(expected), "{said}");
}

/// Also for one who may write everywhere: not even he writes to a disk that is mounted so.
#[test]
fn a_read_only_disk_is_refused_before_anything_is_flown() {
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir(place.path().join("disk")).unwrap();
    let mount = "mount -t tmpfs none disk && mount -o remount,ro disk && cd disk && ";
    let bench = "exec \"$0\" bench --no-gpu --suite smoke --out results";
    let Some(output) = in_namespace(place.path(), &format!("{mount}{bench}")) else { return };
    check(&output, place.path(), "a read-only disk");
}

#[test]
fn a_report_that_cannot_be_written_leaves_none() {
    let place = tempfile::tempdir().unwrap();
    assert!(bench_after(place.path(), "").status.success());
    let report = |preparations: &str, more: &str| {
        let script = format!("{preparations} exec \"$0\" report results {more}");
        let arguments = ["-c", &script, env!("CARGO_BIN_EXE_terrain-lod")];
        Command::new("sh").current_dir(place.path()).args(arguments).output().unwrap()
    };
    let page = place.path().join("results/report.html");
    refused(&report("trap '' XFSZ; ulimit -f 8;", ""), "error: cannot write results/report.html");
    assert!(!page.exists(), "half a report");
    assert!(report("", "").status.success());
    let whole = std::fs::read(&page).unwrap();
    refused(&report("trap '' XFSZ; ulimit -f 8;", ""), "error: cannot write results/report.html");
    assert!(std::fs::read(&page).unwrap() == whole, "the report of before is still there");
    refused(&report("", "--svg results/report.html"), "error: cannot write results/report.html");
    let left: Vec<_> =
        std::fs::read_dir(place.path().join("results")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains("partial")), "{left:?}");
    let mount = "mount --bind results results && mount -o remount,bind,ro results && ";
    if let Some(output) = in_namespace(place.path(), &format!("{mount}exec \"$0\" report results")) {
        refused(&output, "error: cannot write results/report.html");
    }
}

/// What cannot be told is a failure, whatever lies in the folder.
#[test]
fn a_full_stdout_is_said() {
    let full = Path::new("/dev/full");
    if !full.exists() {
        return eprintln!("skipped: no {}", full.display());
    }
    let place = tempfile::tempdir().unwrap();
    for command in ["bench --no-gpu --suite smoke -m rqt --out results", "report results", "cmp results results"] {
        let script = format!("exec \"$0\" {command} > {}", full.display());
        let arguments = ["-c", &script, env!("CARGO_BIN_EXE_terrain-lod")];
        let output = Command::new("sh").current_dir(place.path()).args(arguments).output().unwrap();
        refused(&output, "error: cannot write to stdout");
    }
}
