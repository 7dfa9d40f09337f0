//! What the bench of parts is asked for, and the figures that it keeps.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// A part is repeated for this long, and at least [`FEWEST`] times.
const LONG_ENOUGH: Duration = Duration::from_millis(500);
const FEWEST: usize = 3;

/// What the command line asks for.
pub(crate) struct Wishes {
    /// Cells an edge of the cube.
    pub(crate) cells: usize,
    only: Option<String>,
    save: Option<String>,
    against: Option<String>,
}

impl Wishes {
    pub(crate) fn read() -> Self {
        let arguments: Vec<String> = std::env::args().collect();
        let value = |name: &str| {
            let at = arguments.iter().position(|argument| argument == name)?;
            arguments.get(at + 1).cloned()
        };
        Self {
            cells: value("--cells")
                .and_then(|text| text.parse().ok())
                .unwrap_or(24),
            only: value("--only"),
            save: value("--save"),
            against: value("--against"),
        }
    }
}

/// A figure by part, instruction set and threads.
type Key = (String, String, usize);

/// Prints figures as they come and keeps them.
pub(crate) struct Notebook {
    pub(crate) wishes: Wishes,
    earlier: BTreeMap<Key, f64>,
    seconds: BTreeMap<Key, f64>,
}

impl Notebook {
    pub(crate) fn new(wishes: Wishes) -> Self {
        let text = wishes
            .against
            .as_ref()
            .and_then(|path| std::fs::read_to_string(path).ok());
        let earlier = text
            .iter()
            .flat_map(|text| text.lines())
            .filter_map(figure)
            .collect();
        println!(
            "part                     set       threads     median s  unknowns/s    ratio to saved"
        );
        Self {
            wishes,
            earlier,
            seconds: BTreeMap::new(),
        }
    }

    /// Measures `task`, which handles `unknowns` numbers, in a pool of its own.
    pub(crate) fn measure(
        &mut self,
        part: &str,
        set: &str,
        threads: usize,
        unknowns: usize,
        mut task: impl FnMut() + Send,
    ) {
        if self
            .wishes
            .only
            .as_ref()
            .is_some_and(|only| !part.contains(only.as_str()))
        {
            return;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let Ok(pool) = pool else { return };
        let seconds = pool.install(|| {
            task();
            let (start, mut taken) = (Instant::now(), Vec::new());
            while taken.len() < FEWEST || start.elapsed() < LONG_ENOUGH {
                let one = Instant::now();
                task();
                taken.push(one.elapsed().as_secs_f64());
            }
            taken.sort_by(f64::total_cmp);
            taken[taken.len() / 2]
        });
        let key = (part.to_owned(), set.to_owned(), threads);
        let ratio = self
            .earlier
            .get(&key)
            .map_or_else(String::new, |saved| format!("{:.3}", seconds / saved));
        let rate = unknowns as f64 / seconds;
        println!("{part:24} {set:9} {threads:7} {seconds:12.3e} {rate:11.3e} {ratio:>17}");
        self.seconds.insert(key, seconds);
    }

    pub(crate) fn save(&self) -> std::io::Result<()> {
        let Some(path) = &self.wishes.save else {
            return Ok(());
        };
        let lines = self
            .seconds
            .iter()
            .map(|((part, set, threads), seconds)| format!("{part},{set},{threads},{seconds:e}\n"));
        std::fs::write(path, lines.collect::<String>())
    }
}

fn figure(line: &str) -> Option<(Key, f64)> {
    let parts: Vec<&str> = line.split(',').collect();
    let [part, set, threads, seconds] = parts.as_slice() else {
        return None;
    };
    Some((
        ((*part).to_owned(), (*set).to_owned(), threads.parse().ok()?),
        seconds.parse().ok()?,
    ))
}
