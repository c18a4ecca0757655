//! What a message is: a name, a schema, a form in CDR. All three come from one definition, by `messages!`.

use super::cdr::{Cdr, Decoder, Encoder};

/// Between the definitions in a schema, as ROS has it.
const SEPARATOR: &str = "================================================================================\n";

/// A message that has a topic of its own.
pub trait Message: Cdr + Default {
    /// Its name in full: `nav_msgs/msg/Odometry`.
    const NAME: &'static str;

    /// Its definition and those of all messages in it, in the concatenated form of `ros2msg`.
    #[must_use]
    fn schema() -> String {
        let mut definitions = Vec::new();
        Self::define(&mut definitions);
        let mut definitions = definitions.into_iter();
        let mut schema = definitions.next().map_or_else(String::new, |(_, text)| text);
        for (name, text) in definitions {
            schema += &format!("{SEPARATOR}MSG: {name}\n{text}");
        }
        schema
    }

    /// Writes all of it.
    fn write(&self, encoder: &mut Encoder) {
        encoder.begin();
        self.encode(encoder);
    }

    /// Reads it from a message of a log.
    ///
    /// # Errors
    /// [`CdrError`](super::cdr::CdrError).
    fn read(bytes: &[u8]) -> Result<Self, super::cdr::CdrError> {
        Self::decode(&mut Decoder::new(bytes)?)
    }
}

/// Defines messages: a struct of public fields each, its CDR, and its `.msg` text with the comments of the struct's own fields.
/// Constants come first. `Name = "package", "Name"`.
macro_rules! messages {
    ($(
        $(#[doc = $doc:literal])*
        $name:ident = $package:literal $(, [$($constant:literal)*])? {
            $($(#[doc = $comment:literal])* $field:ident: $type:ty,)*
        }
    )*) => {$(
        $(#[doc = $doc])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $name {
            $($(#[doc = $comment])* pub $field: $type,)*
        }

        impl $crate::cdr::Cdr for $name {
            fn ros_type() -> String {
                concat!($package, "/", stringify!($name)).to_owned()
            }

            fn define(definitions: &mut Vec<(&'static str, String)>) {
                let name = concat!($package, "/", stringify!($name));
                if definitions.iter().any(|(known, _)| *known == name) {
                    return;
                }
                let mut text = String::new();
                $($(text += concat!($constant, "\n");)*)?
                $(
                    $(text += concat!("#", $comment, "\n");)*
                    text += &<$type as $crate::cdr::Cdr>::ros_type();
                    // A field may have the name of a keyword.
                    text += " ";
                    text += stringify!($field).trim_start_matches("r#");
                    text += "\n";
                )*
                definitions.push((name, text));
                $(<$type as $crate::cdr::Cdr>::define(definitions);)*
            }

            fn encode(&self, encoder: &mut $crate::cdr::Encoder) {
                $(self.$field.encode(encoder);)*
            }

            fn decode(decoder: &mut $crate::cdr::Decoder<'_>) -> Result<Self, $crate::cdr::CdrError> {
                Ok(Self { $($field: $crate::cdr::Cdr::decode(decoder)?,)* })
            }
        }

        impl $crate::message::Message for $name {
            const NAME: &'static str = concat!($package, "/msg/", stringify!($name));
        }
    )*};
}

pub(crate) use messages;
