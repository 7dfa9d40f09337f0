//! Methods to compare with reach the solver where the program brings them, and are refused where
//! it does not.

use signorini_compare::Methods;
use signorini_server::{Compared, Config};

use crate::common::{Block, Server, open};

/// Force of the ball by a method for contact.
async fn force(server: &Server, block: &Block, contact: &str) -> [f64; 3] {
    let mut scene = block.scene();
    scene.solver.get_or_insert_default().contact = contact.to_owned();
    let session = server.session(scene).await;
    let mut stream = server.open(open(&session)).await;
    stream.press(1, 0.05).await;
    stream.half_close();
    let report = stream.result().await.report.unwrap();
    let force = &report.obstacles["ball"].force;
    [force[0], force[1], force[2]]
}

#[tokio::test]
async fn scenes_may_name_methods_that_the_program_brings() {
    let config = Config {
        compared: Compared::with(Methods),
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let own = force(&server, &block, "one-level").await;
    let other = force(&server, &block, "active-set").await;
    // Another method leaves other bits.
    let is_other = own.map(f64::to_bits) != other.map(f64::to_bits);
    assert!(own[2] < 0.0 && is_other, "{own:?} {other:?}");
    let apart = own.iter().zip(&other).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6 * own[2].abs());
}
