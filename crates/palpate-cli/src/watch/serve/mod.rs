//! The page of `palpate watch --serve`: one page, and the estimates as server-sent events, over HTTP from the program itself.
//!
//! The page is on the loopback unless another address is asked for, and then asks for a token. Requests are short and soon over, connections are
//! few, and whoever does not take what is sent is dropped: nothing that a viewer does holds up the estimates.

mod frame;
mod request;
mod viewers;

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use palpate::Sample;
use palpate::live::Estimate;
use palpate::pivot::{PadPose, PivotSample, StrokesEstimate};
use palpate_live::Losses;

use crate::terminal::Failure;

use request::{Request, Trouble};
use viewers::Viewers;

/// Where the page is if nothing is said of it.
pub const USUAL_ADDRESS: &str = "127.0.0.1:8377";

/// Connections at a time at most.
const MOST_CONNECTIONS: usize = 128;
/// Time that a viewer has to take what is sent.
const PATIENCE: Duration = Duration::from_secs(5);
/// Stack of the thread of a connection, bytes.
const STACK_BYTES: usize = 256 * 1024;

const PAGE: &str = include_str!("page.html");

/// What every answer says: nothing else is loaded, nothing is kept, and no other page has anything to do with it.
const HEADERS: &str = "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
    Content-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:; connect-src 'self'; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'\r\nConnection: close\r\n";

/// The page, while it is served.
pub struct Server {
    viewers: Arc<Viewers>,
    url: String,
}

/// Who may look.
struct Access {
    address: SocketAddr,
    /// Asked of whoever is not on the loopback.
    token: Option<String>,
}

impl Server {
    /// Begins to serve.
    pub fn start(address: SocketAddr, title: &str) -> Result<Self, Failure> {
        let failed = |error: std::io::Error| Failure::Other(format!("--serve {address}: {error}"));
        let listener = TcpListener::bind(address).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let token = if address.ip().is_loopback() { None } else { Some(token()?) };
        // Of all addresses of this machine one that is always there.
        let ip = if address.ip().is_unspecified() { Ipv4Addr::LOCALHOST.into() } else { address.ip() };
        let host = SocketAddr::new(ip, address.port());
        let query = token.as_ref().map_or_else(String::new, |token| format!("?token={token}"));
        let url = format!("http://{host}/{query}");
        let viewers = Arc::new(Viewers::new(title));
        let of_thread = Arc::clone(&viewers);
        let access = Arc::new(Access { address, token });
        let accept = move || accept(&listener, &access, &of_thread);
        std::thread::Builder::new().name("page".to_owned()).spawn(accept).map_err(failed)?;
        Ok(Self { viewers, url })
    }

    /// Where the page is, with the token that it asks for.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Shows an estimate to whoever looks.
    pub fn show(&self, sample: &Sample, estimate: &Estimate, losses: Losses, rate_hz: f64) {
        self.viewers.show(&frame::of(sample, estimate, losses, rate_hz), || frame::outline(&estimate.outline));
    }

    /// The same of strokes over a pad.
    pub fn show_strokes(
        &self,
        sample: &PivotSample,
        pad: &PadPose,
        estimate: &StrokesEstimate,
        losses: Losses,
        rate_hz: f64,
    ) {
        let frame = frame::of_strokes(sample, pad, estimate, losses, rate_hz);
        self.viewers.show(&frame, || frame::outline(&estimate.outline));
    }

    /// Tells that there is no more, and what came of it.
    pub fn end(&self, told: &str) {
        self.viewers.end(told);
    }
}

/// 128 random bits.
fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| Failure::Other(format!("no random numbers for a token: {error}")))?;
    Ok(bytes.iter().fold(String::new(), |token, byte| format!("{token}{byte:02x}")))
}

fn accept(listener: &TcpListener, access: &Arc<Access>, viewers: &Arc<Viewers>) {
    let open = Arc::new(AtomicUsize::new(0));
    for connection in listener.incoming() {
        let Ok(mut stream) = connection else {
            // Out of files, say: it may pass.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        if open.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
            open.fetch_sub(1, Ordering::SeqCst);
            // It fits into any buffer; whoever does not read it gets none.
            let _ = stream.set_nonblocking(true);
            let _ = stream.write_all(plain(503, "Service Unavailable", "too many viewers\n").as_bytes());
            continue;
        }
        let (access, viewers, of_thread) = (Arc::clone(access), Arc::clone(viewers), Arc::clone(&open));
        let answer = move || {
            // A viewer that is gone needs no answer.
            let _ = answer(stream, &access, &viewers);
            of_thread.fetch_sub(1, Ordering::SeqCst);
        };
        if std::thread::Builder::new().name("viewer".to_owned()).stack_size(STACK_BYTES).spawn(answer).is_err() {
            open.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

fn answer(mut stream: TcpStream, access: &Access, viewers: &Viewers) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let answer = match Request::read(&mut stream, PATIENCE) {
        Err(Trouble::Gone) => return Ok(()),
        Err(Trouble::Refused(status, why)) => plain(status, why, &format!("{why}\n")),
        Ok(request) => match access.allows(&request) {
            Err((status, why)) => plain(status, why, &format!("{why}\n")),
            Ok(()) => match request.path() {
                "/" => whole(200, "OK", "text/html; charset=utf-8", PAGE),
                "/events" => {
                    let head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n";
                    stream.write_all(format!("{head}{HEADERS}\r\n").as_bytes())?;
                    return viewers.send(&mut stream);
                }
                _ => plain(404, "Not Found", "there is nothing here\n"),
            },
        },
    };
    stream.write_all(answer.as_bytes())
}

fn plain(status: u16, reason: &str, text: &str) -> String {
    whole(status, reason, "text/plain; charset=utf-8", text)
}

fn whole(status: u16, reason: &str, kind: &str, text: &str) -> String {
    let length = text.len();
    format!("HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADERS}\r\n{text}")
}

impl Access {
    /// Whether a request may be answered: no other page of the browser asks it, neither under its own name (Origin) nor under ours (Host: a name
    /// that was made to point here), and whoever is elsewhere has the token.
    fn allows(&self, request: &Request) -> Result<(), (u16, &'static str)> {
        let port = self.address.port();
        let Some(host) = request.host() else { return Err((400, "Bad Request")) };
        let is_local = ["localhost", "127.0.0.1", "[::1]"].iter().any(|name| host == format!("{name}:{port}"));
        // A name may point anywhere; numbers are what they say.
        let is_number = host.parse::<SocketAddr>().is_ok_and(|host| host.port() == port);
        let is_ours = if self.address.ip().is_loopback() { is_local } else { is_local || is_number };
        if !is_ours {
            return Err((403, "Forbidden"));
        }
        if request.origin().is_some_and(|origin| origin != format!("http://{host}")) {
            return Err((403, "Forbidden"));
        }
        match &self.token {
            Some(token) if !request.token().is_some_and(|given| is_same(given, token)) => Err((403, "Forbidden")),
            _ => Ok(()),
        }
    }
}

/// Compares two texts in a time that does not tell where they differ.
fn is_same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn ask(server: &Server, request: &str) -> String {
        let port = server.url().split(['/', ':']).nth(4).expect("a port");
        let mut stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("a connection");
        stream.write_all(request.replace("PORT", port).as_bytes()).expect("a request");
        let mut answer = String::new();
        // An answer before all was read resets the connection.
        let _ = stream.read_to_string(&mut answer);
        answer
    }

    fn status(answer: &str) -> &str {
        answer.split(' ').nth(1).unwrap_or_default()
    }

    #[test]
    fn only_the_page_itself_is_answered() {
        let server = Server::start("127.0.0.1:0".parse().expect("an address"), "test").expect("a server");
        assert!(!server.url().contains("token"));
        let get = |more: &str| ask(&server, &format!("GET / HTTP/1.1\r\n{more}\r\n"));
        let page = get("Host: localhost:PORT\r\n");
        assert_eq!(status(&page), "200");
        assert!(page.ends_with(PAGE) && page.contains("Content-Security-Policy: default-src 'none'"));
        assert_eq!(status(&get("Host: 127.0.0.1:PORT\r\nOrigin: http://127.0.0.1:PORT\r\n")), "200");
        assert_eq!(status(&get("")), "400");
        assert_eq!(status(&get("Host: evil.example:PORT\r\n")), "403", "a name that was made to point here");
        assert_eq!(status(&get("Host: localhost:PORT\r\nOrigin: http://evil.example\r\n")), "403");
        assert_eq!(status(&ask(&server, "GET /../../etc/passwd HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n")), "404");
        assert_eq!(status(&ask(&server, "POST / HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n")), "405");
        assert_eq!(status(&ask(&server, "nonsense\r\n\r\n")), "400");
        let long = format!("GET / HTTP/1.1\r\nHost: localhost:PORT\r\nX: {}\r\n\r\n", "x".repeat(100_000));
        assert!(["431", ""].contains(&status(&ask(&server, &long))), "too long, or reset before it was read");
    }

    #[test]
    fn from_elsewhere_a_token_is_asked_for() {
        let server = Server::start("0.0.0.0:0".parse().expect("an address"), "test").expect("a server");
        let token = server.url().split("token=").nth(1).expect("a token").to_owned();
        assert_eq!(token.len(), 32);
        let get = |query: &str| ask(&server, &format!("GET /{query} HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n"));
        assert_eq!(status(&get(&format!("?token={token}"))), "200");
        for query in ["", "?token=", "?token=00", &format!("?token={}", "0".repeat(32)), &format!("events?t={token}")] {
            assert_eq!(status(&get(query)), "403", "{query}");
        }
    }

    #[test]
    fn whoever_comes_late_sees_the_past_and_the_end() {
        let server = Server::start("127.0.0.1:0".parse().expect("an address"), "late").expect("a server");
        let sample = Sample::new(1.5, palpate::palms::PalmPair::hinged(1.0, 1.2), 0.03, 0.03);
        let mut estimate = Estimate::default();
        for time_s in [1.5, 2.5] {
            estimate.time_s = time_s;
            server.show(&sample, &estimate, Losses::default(), 100.0);
        }
        server.end("certified: nothing");
        let answer = ask(&server, "GET /events HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n");
        assert_eq!(status(&answer), "200");
        let strokes = PivotSample { time_s: 3.5, pivot_x_m: 0.5, pivot_y_m: 0.031, s_m: None };
        let pad = PadPose::default();
        let late = Server::start("127.0.0.1:0".parse().expect("an address"), "late").expect("a server");
        let mut strokes_estimate = StrokesEstimate::default();
        strokes_estimate.time_s = 3.5;
        late.show_strokes(&strokes, &pad, &strokes_estimate, Losses::default(), 20.0);
        late.end("not certified");
        let of_strokes = ask(&late, "GET /events HTTP/1.1\r\nHost: localhost:PORT\r\n\r\n");
        assert!(of_strokes.contains("\"pivot\":[500.0,31.0]") && of_strokes.contains("\"t\":3.5"), "{of_strokes}");
        for expected in [
            "event: title\ndata: \"late\"",
            "event: past\ndata: [{",
            "\"t\":1.5",
            "\"t\":2.5",
            "event: end\ndata: \"certified: nothing\"",
        ] {
            assert!(answer.contains(expected), "{expected}: {answer}");
        }
    }
}
