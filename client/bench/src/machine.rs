//! What a figure has to say about where its numbers come from.

/// Processor, cores, threads and build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Machine {
    /// Model name of the processor.
    pub(crate) processor: String,
    /// Cores that this process may use; the solver takes a thread for each.
    pub(crate) cores: usize,
    /// Version and commit.
    pub(crate) build: String,
}

impl Machine {
    /// The one this process runs on; `build.rs` names the commit.
    pub(crate) fn here() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            processor: processor().unwrap_or_else(|| "unknown processor".to_owned()),
            cores,
            build: build(),
        }
    }

    /// One line, with the instruction sets that the results name.
    pub(crate) fn line(&self, instruction_sets: &str) -> String {
        let Self {
            processor,
            cores,
            build,
        } = self;
        let sets = match instruction_sets {
            "" => "unknown",
            sets => sets,
        };
        format!("{processor}, {cores} cores, {cores} threads, instruction set {sets}, {build}")
    }
}

fn build() -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!("signorini {version}, commit {}", env!("SIGNORINI_COMMIT"))
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let mut lines = text.lines().filter_map(|line| line.split_once(':'));
    let name = lines.find(|(key, _)| key.trim() == "model name")?;
    Some(name.1.trim().to_owned())
}
