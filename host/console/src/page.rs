//! The files of the page, as they are served: part of the program, so that nothing else is needed.

/// A file.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Its path in the address.
    pub path: &'static str,
    /// Its `Content-Type`.
    pub kind: &'static str,
    /// What it holds.
    pub bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const JSON: &str = "application/json";

macro_rules! assets {
    ($($path:literal, $kind:expr, $file:literal;)*) => {
        &[$(Asset { path: $path, kind: $kind, bytes: include_bytes!(concat!("../page/", $file)) },)*]
    };
}

/// All of them.
pub const ASSETS: &[Asset] = assets! {
    "/", HTML, "index.html";
    "/style.css", STYLE, "style.css";
    "/icon.svg", PICTURE, "icon.svg";
    "/main.js", SCRIPT, "main.js";
    "/boats.js", SCRIPT, "boats.js";
    "/camera.js", SCRIPT, "camera.js";
    "/connection.js", SCRIPT, "connection.js";
    "/draw.js", SCRIPT, "draw.js";
    "/format.js", SCRIPT, "format.js";
    "/modules.js", SCRIPT, "modules.js";
    "/orders.js", SCRIPT, "orders.js";
    "/player.js", SCRIPT, "player.js";
    "/plots.js", SCRIPT, "plots.js";
    "/rovs.js", SCRIPT, "rovs.js";
    "/state.js", SCRIPT, "state.js";
    "/steer.js", SCRIPT, "steer.js";
    "/layout.json", JSON, "layout.json";
};

/// The one at `path`.
#[must_use]
pub fn asset(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_page_names_is_served() {
        for asset in ASSETS.iter().filter(|asset| asset.kind == HTML || asset.kind == SCRIPT) {
            let text = str::from_utf8(asset.bytes).expect("UTF-8");
            let quoted = text.split(['"', '\'', '`']).skip(1).step_by(2);
            for name in quoted.filter(|name| name.ends_with(".js") || name.ends_with(".css")) {
                let path = format!("/{}", name.trim_start_matches(['.', '/']));
                assert!(super::asset(&path).is_some(), "{} names {name}", asset.path);
            }
            assert!(!text.contains("https://"), "{}: the page needs nothing else", asset.path);
        }
    }
}
