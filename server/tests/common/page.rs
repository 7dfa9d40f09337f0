//! The operator's page, read over plain HTTP.

/// The metrics page.
pub(crate) async fn page(url: &str) -> String {
    let answer = answer(url, "GET", "/metrics").await;
    assert!(answer.starts_with("HTTP/1.1 200 OK"), "{answer}");
    answer
}

/// What the server of a metrics page answers.
pub(crate) async fn answer(url: &str, method: &str, path: &str) -> String {
    answer_to(url, &format!("{method} {path}"), &[]).await
}

/// What it answers to a method and path with further headers, `Host` among them or not.
pub(crate) async fn answer_to(url: &str, asked: &str, headers: &[(&str, &str)]) -> String {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let address = url
        .strip_prefix("http://")
        .unwrap()
        .strip_suffix("/metrics")
        .unwrap();
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let mut request = format!("{asked} HTTP/1.1\r\nConnection: close\r\n");
    if !headers.iter().any(|(name, _)| *name == "Host") {
        request += &format!("Host: {address}\r\n");
    }
    for (name, value) in headers {
        request += &format!("{name}: {value}\r\n");
    }
    stream
        .write_all((request + "\r\n").as_bytes())
        .await
        .unwrap();
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
