//! What a data folder costs: the same updates without and with one, by turns.

use std::time::Instant;

use signorini_client::solve::{Attach, Solve};
use signorini_server::Config;

use crate::server::{Scene, Server, ball, press, result};

/// Turns of each kind.
const TURNS: u32 = 5;

/// One client that waits for each result, and one that sends eight updates ahead.
pub(crate) async fn run(count: u32) {
    let folder = std::env::temp_dir().join(format!("signorini-journal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    println!(
        "one wait for this disk: {:.2} ms",
        1e3 * sync_seconds(&folder)
    );
    let data = folder.join("data").to_str().unwrap().to_owned();
    let config = Config {
        data,
        ..Config::embedded()
    };
    let (mut without, mut with) = (driver(Config::embedded()).await, driver(config).await);
    for ahead in [1, 8] {
        let mut rates = [Vec::new(), Vec::new()];
        for _ in 0..TURNS {
            rates[0].push(rate(&mut without, count, ahead).await);
            rates[1].push(rate(&mut with, count, ahead).await);
        }
        let [without, with] = rates.map(median);
        let cost = 100.0 * (1.0 - with / without);
        println!(
            "{ahead} ahead: {without:.1} updates/s without, {with:.1} with a data folder: {cost:.1} %"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

async fn driver(config: Config) -> Solve {
    let server = Server::start(config).await;
    let session = server.session(&Scene::sphere(1).tolerance(1e-8)).await;
    let mut solve = server
        .client
        .solve(&session, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(press(0.05, 1)).await.unwrap();
    result(&mut solve.events).await;
    solve
}

/// Updates a second, `ahead` under way at a time.
async fn rate(solve: &mut Solve, count: u32, ahead: u32) -> f64 {
    let depth = |index: u32| 0.05 * (1.0 + 0.01 * f64::from(index % 10));
    let start = Instant::now();
    for index in 0..count + ahead - 1 {
        if index < count {
            solve
                .updates
                .obstacle_update(ball(depth(index)))
                .await
                .unwrap();
        }
        if index + 1 >= ahead {
            result(&mut solve.events).await;
        }
    }
    f64::from(count) / start.elapsed().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The median time that the disk takes for one small change.
fn sync_seconds(folder: &std::path::Path) -> f64 {
    use std::io::Write as _;
    let mut file = std::fs::File::create(folder.join("sync")).unwrap();
    let one = |_| {
        let start = Instant::now();
        file.write_all(&[1; 4096]).unwrap();
        file.sync_data().unwrap();
        start.elapsed().as_secs_f64()
    };
    median((0..51).map(one).collect())
}
