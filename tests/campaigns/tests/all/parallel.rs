//! Shards under GNU parallel.

use std::process::Command;

use crate::program::{PROGRAM, folder, judge, output, said, scheduler, study};

#[test]
fn shards_run_under_gnu_parallel() {
    if !output(Command::new("sh").args(["-c", "command -v parallel"])).status.success() {
        said(Command::new("apt-get").args(["update", "-qq"]));
        said(
            Command::new("apt-get")
                .args(["install", "-y", "-qq", "parallel"])
                .env("DEBIAN_FRONTEND", "noninteractive"),
        );
    }
    let folder = folder("parallel");
    let mut command = Command::new(scheduler("with-parallel"));
    command.arg(study("two-hundred.toml")).arg(&folder).arg("4").env("CAMPAIGN", PROGRAM);
    said(&mut command);
    judge(&folder);
}
