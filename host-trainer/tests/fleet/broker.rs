//! A mosquitto of a test's own.

use std::fs;
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Program of a name, in the folders of daemons as well; says so where there is none.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
    let found = folders.map(|folder| folder.join(name)).find(|path| path.is_file());
    if found.is_none() {
        eprintln!("SKIPPED: no {name} on this machine; .ci/run tools installs it");
    }
    found
}

/// A broker that keeps its state in a folder.
pub struct Broker {
    pub port: u16,
    program: PathBuf,
    config: PathBuf,
    child: Option<Child>,
}

impl Broker {
    /// Starts a broker on a free port; `None` where mosquitto is not installed.
    pub fn start(folder: &Path, settings: &str) -> Option<Self> {
        let program = program("mosquitto")?;
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let config = folder.join("mosquitto.conf");
        let text = format!(
            "user root\nlistener {port} 127.0.0.1\npersistence true\npersistence_location {}/\n\
             max_queued_messages 0\nmax_inflight_messages 100\n{settings}\n",
            folder.display()
        );
        fs::write(&config, text).unwrap();
        let mut broker = Self { port, program, config, child: None };
        broker.restart();
        Some(broker)
    }

    pub fn restart(&mut self) {
        let mut command = Command::new(&self.program);
        let log = fs::File::options().create(true).append(true).open(self.config.with_extension("log")).unwrap();
        self.child = Some(command.arg("-c").arg(&self.config).stdout(Stdio::null()).stderr(log).spawn().unwrap());
        let start = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(start.elapsed() < Duration::from_secs(10), "mosquitto does not listen");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Ends the broker as an administrator does; it writes its state.
    pub fn stop(&mut self) {
        let mut child = self.child.take().expect("running");
        assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
        child.wait().unwrap();
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
