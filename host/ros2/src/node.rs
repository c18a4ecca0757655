//! The node: names, and qualities of service as ROS's tools expect them.

use std::time::Duration;

use pose::ros2::Topics;
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile,
    Server, ServiceMapping, ServiceTypeName, Subscription,
};
use thiserror::Error;

use crate::shown::Quality;
use crate::wire::{Ready, TriggerRequest, TriggerResponse};

/// The greatest domain: ports of more would not fit below 65536 (DDSI-RTPS 2.5, 9.6.2.3).
pub const DOMAIN_MAX: u16 = 232;

/// Why there is no node, or no topic.
#[derive(Debug, Error)]
pub enum NodeError {
    /// A name that ROS does not have.
    #[error(
        "\"{0}\" is no namespace: letters, digits and \"_\", parts separated by \"/\", as in flotilla or lab/boats"
    )]
    Namespace(String),
    /// DDS.
    #[error("{what}, DDS domain {domain}: {reason}")]
    Dds {
        /// What was to be made.
        what: String,
        /// Where.
        domain: u16,
        /// What DDS said.
        reason: String,
    },
}

/// A namespace as topics have it in front: `/lab/boats`, or nothing for the root.
///
/// # Errors
/// [`NodeError::Namespace`].
pub fn namespace(given: &str) -> Result<String, NodeError> {
    let bare = given.strip_prefix('/').unwrap_or(given);
    if bare.is_empty() {
        return Ok(String::new());
    }
    let name = format!("/{bare}");
    // A namespace follows the rules of a topic.
    match name.parse::<Topics>() {
        Ok(Topics { topics, frame: None })
            if topics.len() == 1 && topics.iter().all(|one| one.name == name) =>
        {
            Ok(name)
        }
        _ => Err(NodeError::Namespace(given.to_owned())),
    }
}

/// A node of ROS.
pub struct Ros {
    context: Context,
    /// It.
    pub node: Node,
    domain: u16,
}

impl Ros {
    /// The node `name` in `namespace`, in a DDS domain.
    ///
    /// # Errors
    /// [`NodeError::Dds`].
    pub fn open(domain: u16, namespace: &str, name: &str) -> Result<Self, NodeError> {
        let failed =
            |reason: String| NodeError::Dds { what: format!("node {namespace}/{name}"), domain, reason };
        let context = Context::with_options(ContextOptions::new().domain_id(domain));
        let context = context.map_err(|error| failed(error.to_string()))?;
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        let node_name = NodeName::new(namespace, name).map_err(|error| failed(format!("{error:?}")))?;
        let options = NodeOptions::new().enable_rosout(true).start_parameter_services(false);
        let node = context.new_node(node_name, options).map_err(|error| failed(format!("{error:?}")))?;
        Ok(Self { context, node, domain })
    }

    fn failed(&self, topic: &str, reason: impl ToString) -> NodeError {
        NodeError::Dds { what: topic.to_owned(), domain: self.domain, reason: reason.to_string() }
    }

    fn name(&self, topic: &str) -> Result<Name, NodeError> {
        Name::parse(topic).map_err(|error| self.failed(topic, format!("{error:?}")))
    }

    /// Publishes what is in CDR already.
    ///
    /// # Errors
    /// [`NodeError::Dds`].
    pub fn publisher(
        &mut self,
        topic: &str,
        (package, kind): (&str, &str),
        quality: Quality,
    ) -> Result<Publisher<Ready>, NodeError> {
        let (name, qos) = (self.name(topic)?, qos(quality));
        let made = self.node.create_topic(&name, MessageTypeName::new(package, kind), &qos);
        let made = made.and_then(|made| self.node.create_publisher(&made, Some(qos)));
        made.map_err(|error| self.failed(topic, error))
    }

    /// Listens to the newest messages of a topic, which any publisher of it may send.
    ///
    /// # Errors
    /// [`NodeError::Dds`].
    pub fn subscription<M: 'static>(
        &mut self,
        topic: &str,
        (package, kind): (&str, &str),
    ) -> Result<Subscription<M>, NodeError> {
        let (name, qos) = (self.name(topic)?, qos(Quality::Sensor));
        let made = self.node.create_topic(&name, MessageTypeName::new(package, kind), &qos);
        let made = made.and_then(|made| self.node.create_subscription(&made, Some(qos)));
        made.map_err(|error| self.failed(topic, error))
    }

    /// Serves `std_srvs/Trigger`.
    ///
    /// # Errors
    /// [`NodeError::Dds`].
    pub fn trigger(
        &mut self,
        service: &str,
        mapping: ServiceMapping,
    ) -> Result<Server<TriggerRequest, TriggerResponse>, NodeError> {
        let (name, kind) = (self.name(service)?, ServiceTypeName::new("std_srvs", "Trigger"));
        let made =
            self.node.create_server(mapping, &name, &kind, qos(Quality::Reliable), qos(Quality::Reliable));
        made.map_err(|error| self.failed(service, error))
    }

    /// The type of a topic that is published somewhere: package and name.
    #[must_use]
    pub fn kind_of(&self, topic: &str) -> Option<(String, String)> {
        let writers = self.context.domain_participant().discovered_writers();
        let kinds = writers.iter().map(|writer| &writer.publication_topic_data);
        kinds
            .filter(|data| data.topic_name.strip_prefix("rt") == Some(topic))
            .find_map(|data| message(&data.type_name))
    }
}

/// `geometry_msgs::msg::dds_::PoseStamped_` taken apart.
fn message(dds: &str) -> Option<(String, String)> {
    let (package, rest) = dds.split_once("::msg::dds_::")?;
    Some((package.to_owned(), rest.strip_suffix('_')?.to_owned()))
}

/// Writers never wait for a slow reader: what finds no room is dropped, and counted.
fn qos(quality: Quality) -> QosProfile {
    let profile = QosProfile::subscription_default();
    let kept = |depth| profile.clone().history(History::KeepLast { depth });
    let reliable = WhenFull::Wait(Duration::ZERO);
    match quality {
        Quality::Sensor => kept(5).reliability_best_effort(),
        Quality::Transforms => kept(100).reliability_reliable(reliable),
        Quality::Latched => kept(1).reliability_reliable(reliable).durability(Durability::TransientLocal),
        Quality::Reliable => kept(10).reliability_reliable(reliable),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_are_those_that_ros_has() {
        for (given, expected) in
            [("flotilla", "/flotilla"), ("/lab/boats", "/lab/boats"), ("/", ""), ("", "")]
        {
            assert_eq!(namespace(given).expect(given), expected);
        }
        for wrong in ["a b", "a,b", "a/", "1a", "x=a", "a@b", "//a"] {
            assert!(namespace(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn types_are_read_as_dds_has_them() {
        let pose = message("geometry_msgs::msg::dds_::PoseStamped_").expect("a type");
        assert_eq!(pose, ("geometry_msgs".to_owned(), "PoseStamped".to_owned()));
        assert_eq!(message("PoseStamped"), None);
    }
}
