//! The head of a request, read within limits of size and time. Nothing else of a request is read.

use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest head, bytes, and headers in it.
const LONGEST: usize = 8192;
const MOST_HEADERS: usize = 64;

/// What is asked.
#[derive(Debug)]
pub struct Request {
    target: String,
    host: Option<String>,
    origin: Option<String>,
}

/// Why there is no request.
#[derive(Debug)]
pub enum Trouble {
    /// The connection ended, or said nothing for too long.
    Gone,
    /// It is none that is answered: status and reason.
    Refused(u16, &'static str),
}

impl Request {
    /// Reads the head of a request that is there within this time.
    pub fn read(stream: &mut TcpStream, patience: Duration) -> Result<Self, Trouble> {
        let deadline = Instant::now() + patience;
        let mut head = Vec::new();
        let mut bytes = [0; 1024];
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
                return Err(Trouble::Gone);
            }
            match stream.read(&mut bytes) {
                Ok(0) | Err(_) => return Err(Trouble::Gone),
                Ok(count) => head.extend_from_slice(&bytes[..count]),
            }
            if let Some(request) = Self::parse(&head)? {
                return Ok(request);
            }
            if head.len() > LONGEST {
                return Err(Trouble::Refused(431, "Request Header Fields Too Large"));
            }
        }
    }

    /// `None` where the head is not all there.
    fn parse(head: &[u8]) -> Result<Option<Self>, Trouble> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(head) {
            Ok(httparse::Status::Complete(_)) => {}
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => {
                return Err(Trouble::Refused(431, "Request Header Fields Too Large"));
            }
            Err(_) => return Err(Trouble::Refused(400, "Bad Request")),
        }
        if request.method != Some("GET") {
            return Err(Trouble::Refused(405, "Method Not Allowed"));
        }
        let value = |name: &str| {
            let mut all = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
            let first = all.next().and_then(|header| std::str::from_utf8(header.value).ok());
            // Of two nobody knows which counts.
            first.filter(|_| all.next().is_none()).map(str::to_owned)
        };
        let target = request.path.unwrap_or_default().to_owned();
        Ok(Some(Self { target, host: value("Host"), origin: value("Origin") }))
    }

    /// What is asked for.
    pub fn path(&self) -> &str {
        self.target.split('?').next().unwrap_or_default()
    }

    /// What the viewer calls this machine.
    pub fn host(&self) -> Option<&str> {
        self.host.as_deref()
    }

    /// The page that asks, where the browser says so.
    pub fn origin(&self) -> Option<&str> {
        self.origin.as_deref()
    }

    /// The token that was given.
    pub fn token(&self) -> Option<&str> {
        let query = self.target.split_once('?')?.1;
        query.split('&').find_map(|pair| pair.strip_prefix("token="))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_is_understood_when_it_is_all_there() {
        let text = b"GET /events?a=b&token=secret HTTP/1.1\r\nhost: localhost:1\r\nOrigin: http://x\r\n\r\n";
        for end in 0..text.len() {
            assert!(matches!(Request::parse(&text[..end]), Ok(None)), "{end}");
        }
        let request = Request::parse(text).expect("a request").expect("all of it");
        assert_eq!((request.path(), request.token()), ("/events", Some("secret")));
        assert_eq!((request.host(), request.origin()), (Some("localhost:1"), Some("http://x")));
        let twice = b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n";
        assert_eq!(Request::parse(twice).expect("a request").expect("all of it").host(), None);
    }
}
