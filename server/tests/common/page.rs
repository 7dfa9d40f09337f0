//! The operator's page, read over plain HTTP.

/// The metrics page.
pub(crate) async fn page(url: &str) -> String {
    let answer = answer(url, "GET", "/metrics").await;
    assert!(answer.starts_with("HTTP/1.1 200 OK"), "{answer}");
    answer
}

/// What the server of a metrics page answers.
pub(crate) async fn answer(url: &str, method: &str, path: &str) -> String {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let address = url
        .strip_prefix("http://")
        .unwrap()
        .strip_suffix("/metrics")
        .unwrap();
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let request =
        format!("{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer
}

/// A whole number of the page.
pub(crate) fn sample(page: &str, series: &str) -> u64 {
    let value = |line: &str| line.strip_prefix(series)?.strip_prefix(' ')?.parse().ok();
    let found: Option<f64> = page.lines().find_map(value);
    found.unwrap_or_else(|| panic!("{series} is missing:\n{page}")) as u64
}
