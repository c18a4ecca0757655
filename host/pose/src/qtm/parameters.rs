//! The settings in XML: which bodies there are, in the order in which data packets have them.
//!
//! Read by a scan for elements, not by a parser of XML: the protocol's own text has neither comments nor namespaces, and what does
//! not fit gives fewer bodies, never an error.

/// A body of the settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BodySetting {
    /// Its name.
    pub name: String,
    /// Whether it is switched on; before 1.25 every one is.
    pub enabled: bool,
}

/// The bodies of `GetParameters 6D`.
pub fn bodies(xml: &str) -> Vec<BodySetting> {
    let Some(section) = elements(xml, "The_6D").next() else { return Vec::new() };
    let settings = elements(section, "Body").map(|body| {
        // The name comes first; a mesh further down has one too.
        let name = elements(body, "Name").next().unwrap_or_default();
        let enabled = elements(body, "Enabled").next();
        BodySetting {
            name: unescaped(name.trim()),
            enabled: enabled.is_none_or(|text| !text.trim().eq_ignore_ascii_case("false")),
        }
    });
    settings.collect()
}

/// The contents of the elements `tag` of `text`, in their order.
fn elements<'a>(text: &'a str, tag: &'a str) -> impl Iterator<Item = &'a str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            let start = rest.find('<')?;
            let inside = rest.get(start + 1..)?;
            let Some(after) =
                inside.strip_prefix(tag).filter(|after| after.starts_with(['>', ' ', '/', '\t', '\r', '\n']))
            else {
                rest = inside;
                continue;
            };
            let (attributes, content) = after.split_once('>')?;
            if attributes.ends_with('/') {
                rest = content;
                return Some("");
            }
            let end = content.find(&format!("</{tag}"))?;
            let (content, behind) = content.split_at_checked(end)?;
            rest = behind;
            return Some(content);
        }
    })
}

fn unescaped(text: &str) -> String {
    let plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'");
    plain.replace("&amp;", "&")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The settings of `names`, as `GetParameters` of protocol 1.`minor` answers: with the elements that the vendor's client of the
/// version asks for. From 1.21 on a body has its settings as elements, before a colour and its points.
pub fn write(minor: u32, names: &[String]) -> String {
    let body = |name: &String| {
        let name = escaped(name);
        let settings = if minor > 20 { SETTINGS } else { "<RGBColor>65280</RGBColor>" };
        format!("<Body><Name>{name}</Name>{settings}</Body>")
    };
    let bodies: String = names.iter().map(body).collect();
    let count = if minor > 20 { String::new() } else { format!("<Bodies>{}</Bodies>", names.len()) };
    let root = format!("QTM_Parameters_Ver_1.{minor}");
    format!("<{root}><The_6D>{count}{bodies}{ANGLES}</The_6D></{root}>")
}

/// QTM's standard angles.
const ANGLES: &str = "<Euler><First>Roll</First><Second>Pitch</Second><Third>Yaw</Third></Euler>";
/// The settings of a body without points.
const SETTINGS: &str = "<Enabled>true</Enabled><Color R=\"0\" G=\"255\" B=\"0\"/><MaximumResidual>10.000000</MaximumResidual>\
    <MinimumMarkersInBody>3</MinimumMarkersInBody><BoneLengthTolerance>5.000000</BoneLengthTolerance>\
    <Filter Preset=\"No filter\"/><Points></Points>\
    <Data_origin X=\"0.000000\" Y=\"0.000000\" Z=\"0.000000\" Relative_body=\"1\">0</Data_origin>\
    <Data_orientation R11=\"1.000000\" R12=\"0.000000\" R13=\"0.000000\" R21=\"0.000000\" R22=\"1.000000\" R23=\"0.000000\" \
    R31=\"0.000000\" R32=\"0.000000\" R33=\"1.000000\" Relative_body=\"1\">0</Data_orientation>";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_of_1_25_with_meshes_and_one_switched_off() {
        let xml = "<QTM_Parameters_Ver_1.25>\n<The_6D>\n<Body>\n<Name>boat &amp; 1</Name>\n<Enabled>true</Enabled>\n\
                   <Color R=\"0\" G=\"255\" B=\"0\"/>\n<Mesh>\n<Name>Arqus.obj</Name>\n</Mesh>\n</Body>\n\
                   <Body>\n<Name>boat 2</Name>\n<Enabled>false</Enabled>\n<Mesh><Name/></Mesh>\n</Body>\n</The_6D>";
        let found = bodies(xml);
        assert_eq!(
            found,
            [
                BodySetting { name: "boat & 1".into(), enabled: true },
                BodySetting { name: "boat 2".into(), enabled: false },
            ]
        );
    }

    #[test]
    fn bodies_of_1_20_where_their_count_comes_first() {
        let xml = "<QTM_Parameters_Ver_1.20><The_6D><Bodies>1</Bodies><Body><Name>Body1</Name><RGBColor>ffffff</RGBColor>\
                   <Point><X>10.5</X></Point></Body></The_6D></QTM_Parameters_Ver_1.20>";
        assert_eq!(bodies(xml), [BodySetting { name: "Body1".into(), enabled: true }]);
    }

    #[test]
    fn what_is_written_is_read() {
        let names: Vec<String> = ["a<b>&c", "Kälte", "&lt;"].map(String::from).into();
        for minor in [19, 25] {
            let found: Vec<String> =
                bodies(&write(minor, &names)).into_iter().map(|body| body.name).collect();
            assert_eq!(found, names);
        }
    }

    #[test]
    fn what_does_not_fit_gives_no_bodies() {
        for xml in ["", "<The_6D>", "<The_6D><Body>", "<The_6D></The_6D>", "<", "<The_6D/>", "ä<ö"] {
            assert_eq!(bodies(xml), [], "{xml}");
        }
    }
}
