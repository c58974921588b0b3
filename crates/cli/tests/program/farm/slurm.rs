//! A job by Slurm, on a cluster of one machine that the test starts: its own munged, slurmctld and slurmd.

use super::{Show, kill_task, list, started, wait_for};
use crate::common::stderr;
use std::fs;
use std::net::TcpListener;
use std::process::{Child, Command, Output};

/// A cluster of this machine alone.
struct Cluster {
    folder: tempfile::TempDir,
    daemons: Vec<Child>,
}

impl Cluster {
    /// `None`, with a skip, where this user may not start one.
    fn start() -> Option<Self> {
        let is_root = Command::new("id").arg("-u").output().unwrap().stdout == b"0\n";
        if !is_root {
            rhytid_test_support::skip("slurmd runs as root alone");
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let host = Command::new("hostname").output().unwrap().stdout;
        let host = String::from_utf8(host).unwrap().trim().to_owned();
        // Ports that nobody has just now.
        let listeners = [0, 1].map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
        let ports = listeners.each_ref().map(|listener| listener.local_addr().unwrap().port());
        drop(listeners);
        let settings = format!(
            "ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n\
             AuthType=auth/munge\nAuthInfo=socket={}\nSlurmctldPort={}\nSlurmdPort={}\n\
             StateSaveLocation={}\nSlurmdSpoolDir={}\nSlurmctldPidFile={}\nSlurmdPidFile={}\n\
             SlurmctldLogFile={}\nSlurmdLogFile={}\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nJobAcctGatherType=jobacct_gather/none\n\
             ReturnToService=2\nMpiDefault=none\nMaxArraySize=2\nSchedulerParameters=sched_interval=1,batch_sched_delay=0\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=day Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n",
            at("munge.sock"),
            ports[0],
            ports[1],
            at("state"),
            at("spool"),
            at("slurmctld.pid"),
            at("slurmd.pid"),
            at("slurmctld.log"),
            at("slurmd.log")
        );
        fs::write(folder.path().join("slurm.conf"), settings).unwrap();
        fs::create_dir(folder.path().join("state")).unwrap();
        fs::create_dir(folder.path().join("spool")).unwrap();
        let key = folder.path().join("key");
        fs::write(&key, [7; 1024]).unwrap();
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&key, fs::Permissions::from_mode(0o600)).unwrap();
        let mut cluster = Self { folder, daemons: Vec::new() };
        let at = |name: &str| cluster.folder.path().join(name).display().to_string();
        let words = [
            ("--socket", "munge.sock"),
            ("--key-file", "key"),
            ("--log-file", "munge.log"),
            ("--pid-file", "munge.pid"),
            ("--seed-file", "munge.seed"),
        ];
        let mut munged = Command::new("munged");
        munged.args(["--foreground", "--force"]);
        munged.args(words.map(|(option, file)| format!("{option}={}", at(file))));
        let [socket, settings] = ["munge.sock", "slurm.conf"].map(at);
        let munged = started(munged);
        cluster.daemons.push(munged);
        wait_for("munged", || fs::exists(&socket).unwrap().then_some(()));
        for daemon in ["slurmctld", "slurmd"] {
            let mut command = Command::new(daemon);
            command.args(["-D", "-f", &settings]);
            cluster.daemons.push(started(command));
        }
        wait_for("the cluster", || {
            let said = cluster.command("sinfo", &["--noheader", "--format=%T"]).output().unwrap();
            (said.stdout == b"idle\n").then_some(())
        });
        Some(cluster)
    }

    fn command(&self, program: &str, words: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(words).env("SLURM_CONF", self.folder.path().join("slurm.conf"));
        command
    }

    /// Submits the job of a show. Returns what the script said.
    fn submit(&self, show: &Show, options: &[&str]) -> String {
        let script = show.path("JOB/slurm.sh").display().to_string();
        let mut command = self.command("sh", &[&[&*script], options].concat());
        command.env("RHYTID", env!("CARGO_BIN_EXE_rhytid")).current_dir("/");
        let output: Output = command.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    fn wait_for_all(&self) {
        wait_for("the end of all jobs", || {
            let said = self.command("squeue", &["--noheader"]).output().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(200));
            (said.status.success() && said.stdout.is_empty()).then_some(())
        });
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // The last one first: each talks to those before it.
        for daemon in self.daemons.iter_mut().rev() {
            let _ = Command::new("kill").arg(daemon.id().to_string()).status();
            let _ = daemon.wait();
        }
    }
}

/// As by Open Job Description: three chunks, one of them killed, and the same command again. An array may
/// have two tasks here, so that the chunks need two arrays.
#[test]
fn slurm_ends_a_job_of_which_a_task_was_killed() {
    let Some(cluster) = Cluster::start() else { return };
    let show = Show::new();
    show.three_chunks();
    let said = cluster.submit(&show, &["--partition=day"]);
    assert!(said.contains("rhytid: animate: 3 tasks in the jobs 1:2"), "{said}");
    assert!(said.contains("rhytid: stitch: 1 tasks in the jobs 3"), "{said}");
    kill_task(&show, 1);
    cluster.wait_for_all();
    let parts = ["speech.000000-000073.usd", "speech.000146-000217.usd"];
    assert_eq!(list(&show.path("JOB/parts")), parts, "a killed task costs its chunk");
    // Stitch came after any end, and says what is missing.
    let log = fs::read_to_string(show.path("JOB/logs/slurm-stitch-3-0.txt")).unwrap();
    assert!(log.contains("1 of 3 parts are missing: parts/speech.000073-000146.usd"), "{log}");
    assert_eq!(show.status(), [("animate".to_owned(), 2, 3), ("stitch".to_owned(), 0, 1)]);
    cluster.submit(&show, &[]);
    cluster.wait_for_all();
    show.assert_whole();
    assert_eq!(show.status(), [("animate".to_owned(), 3, 3), ("stitch".to_owned(), 1, 1)]);
}
