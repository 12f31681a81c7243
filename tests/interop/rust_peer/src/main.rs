// SPDX-License-Identifier: Apache-2.0
//! A ROS 2 node in Rust (ros2-client on RustDDS) that checks a running teleoperated robot; shares
//! no code with Tandem. Exits with 0 if the check succeeds; otherwise panics with the reason.
//!
//!     rust_peer graph | topics | services | parameters | foreign_convention
//!
//! Uses the domain ROS_DOMAIN_ID.

use std::{future::Future, time::Duration};

use futures::{StreamExt, future::FutureExt as _, pin_mut, select};
use ros2_client::{
  Context, ContextOptions, Message, MessageTypeName, Name, Node, NodeEvent, NodeName, NodeOptions, Parameter,
  ParameterValue, QosProfile, ServiceMapping, ServiceTypeName,
  rcl_interfaces::{
    GetParametersRequest, GetParametersResponse, ListParametersRequest, ListParametersResponse,
    SetParametersRequest, SetParametersResponse,
  },
  service::Client,
};
use serde::{Deserialize, Serialize};

const TIMEOUT: Duration = Duration::from_secs(60);
const BEAT: Duration = Duration::from_millis(50);

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Vector3 {
  x: f64,
  y: f64,
  z: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Twist {
  linear: Vector3,
  angular: Vector3,
}
impl Message for Twist {}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct TriggerRequest {
  structure_needs_at_least_one_member: u8,
}
impl Message for TriggerRequest {}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct TriggerResponse {
  success: bool,
  message: String,
}
impl Message for TriggerResponse {}

async fn pause(duration: Duration) {
  smol::Timer::after(duration).await;
}

/// Returns the result of `task`; panics with `what` if it takes longer than `limit`.
async fn within<T>(limit: Duration, what: &str, task: impl Future<Output = T>) -> T {
  let task = task.fuse();
  let late = pause(limit).fuse();
  pin_mut!(task, late);
  select! {
    result = task => result,
    _ = late => panic!("{what}: nothing within {limit:?}"),
  }
}

/// Waits for the service, but at most as long as discovery can take, because wait_for_service of
/// ros2-client 0.12.1 occasionally does not notice that the service is already available.
async fn found<Req, Resp>(node: &Node, client: &Client<Req, Resp>)
where
  Req: Message + Clone + 'static,
  Resp: Message + Clone + 'static,
{
  let service = client.wait_for_service(node).fuse();
  let late = pause(Duration::from_secs(5)).fuse();
  pin_mut!(service, late);
  select! {
    _ = service => (),
    _ = late => println!("the service was not discovered"),
  }
}

async fn call<Req, Resp>(node: &mut Node, mapping: ServiceMapping, of: &str, service: &str,
                         type_name: (&str, &str), request: Req) -> Resp
where
  Req: Message + Clone + 'static,
  Resp: Message + Clone + 'static,
{
  let client = node
    .create_client::<Req, Resp>(
      mapping,
      &Name::new(of, service).unwrap(),
      &ServiceTypeName::new(type_name.0, type_name.1),
      QosProfile::publisher_default(),
      QosProfile::publisher_default(),
    )
    .unwrap();
  found(node, &client).await;
  println!("asks {of}/{service}");
  client.async_call_service(request).await.unwrap_or_else(|error| panic!("{service}: {error:?}"))
}

/// ros_discovery_info lists the robot's nodes.
async fn graph(node: &mut Node) {
  let events = node.status_receiver().unwrap();
  pin_mut!(events);
  loop {
    let Some(NodeEvent::ParticipantEntities(info)) = events.next().await else { continue };
    let names: Vec<_> = info.nodes().iter().map(|n| n.fully_qualified_name()).collect();
    println!("nodes: {names:?}");
    if ["/arbitration", "/safety_filter", "/diff_drive_sim"]
      .iter()
      .all(|wanted| names.iter().any(|name| name == wanted))
    {
      return;
    }
  }
}

/// The robot follows our command, and we receive the command that it is finally given.
async fn topics(node: &mut Node) {
  let type_name = MessageTypeName::new("geometry_msgs", "Twist");
  let topic = |name: &str| {
    node
      .create_topic(&Name::new("/", name).unwrap(), type_name.clone(),
                    &QosProfile::publisher_default())
      .unwrap()
  };
  let (user, command) = (topic("cmd_vel_user"), topic("cmd_vel"));
  let user = node.create_publisher::<Twist>(&user, None).unwrap();
  let command = node.create_subscription::<Twist>(&command, None).unwrap();
  let push = async {
    loop {
      let mut twist = Twist::default();
      twist.linear.x = 0.3;
      user.async_publish(twist).await.unwrap();
      pause(BEAT).await;
    }
  }
  .fuse();
  let drive = async {
    let commands = command.async_stream();
    pin_mut!(commands);
    loop {
      let (twist, _) = commands.next().await.unwrap().unwrap();
      if (twist.linear.x - 0.3).abs() < 1e-9 {
        return;
      }
    }
  }
  .fuse();
  pin_mut!(push, drive);
  select! {
    _ = push => unreachable!(),
    _ = drive => (),
  }
}

async fn services(node: &mut Node) {
  let answer: TriggerResponse = call(node, ServiceMapping::Enhanced, "/diff_drive_sim", "reset",
                                     ("std_srvs", "Trigger"),
                                     TriggerRequest { structure_needs_at_least_one_member: 0 }).await;
  assert!(answer.success, "{answer:?}");
  assert_eq!(answer.message, "at the start");
}

async fn set(node: &mut Node, name: &str, value: ParameterValue) -> (bool, String) {
  let parameter = Parameter { name: name.to_string(), value };
  let answer: SetParametersResponse = call(node, ServiceMapping::Enhanced, "/arbitration",
                                           "set_parameters", ("rcl_interfaces", "SetParameters"),
                                           SetParametersRequest { parameter: vec![parameter.into()] })
  .await;
  let result = &answer.results[0];
  (result.successful, result.reason.clone())
}

async fn parameters(node: &mut Node) {
  let listed: ListParametersResponse = call(node, ServiceMapping::Enhanced, "/arbitration",
                                            "list_parameters",
                                            ("rcl_interfaces", "ListParameters"),
                                            ListParametersRequest { prefixes: vec![], depth: 0 })
  .await;
  assert!(listed.result.names.iter().any(|name| name == "user_timeout"), "{:?}", listed.result.names);
  let got: GetParametersResponse = call(node, ServiceMapping::Enhanced, "/arbitration",
                                        "get_parameters", ("rcl_interfaces", "GetParameters"),
                                        GetParametersRequest { names: vec!["policy".to_string()] })
  .await;
  assert_eq!(ParameterValue::from(got.values[0].clone()),
             ParameterValue::String("manual".to_string()));
  let (done, reason) = set(node, "user_timeout", ParameterValue::Double(-1.0)).await;
  assert!(!done && reason.contains("user_timeout"), "{done} {reason}");
  let (done, reason) = set(node, "no_such", ParameterValue::Double(1.0)).await;
  assert!(!done && reason.contains("no_such"), "{done} {reason}");
}

/// A request with a header in its payload, as rmw_cyclonedds sends it, gets no response and does no
/// harm: the next request in the supported convention is answered.
async fn foreign_convention(node: &mut Node) {
  let client = node
    .create_client::<TriggerRequest, TriggerResponse>(
      ServiceMapping::Cyclone,
      &Name::new("/diff_drive_sim", "reset").unwrap(),
      &ServiceTypeName::new("std_srvs", "Trigger"),
      QosProfile::publisher_default(),
      QosProfile::publisher_default(),
    )
    .unwrap();
  found(node, &client).await;
  let ask = client
    .async_call_service(TriggerRequest { structure_needs_at_least_one_member: 0 })
    .fuse();
  let late = pause(Duration::from_secs(2)).fuse();
  pin_mut!(ask, late);
  select! {
    answer = ask => panic!("a request of the other convention was answered: {answer:?}"),
    _ = late => (),
  }
  services(node).await;
}

fn main() {
  let check = std::env::args().nth(1).expect("which check?");
  let domain = std::env::var("ROS_DOMAIN_ID").map_or(0, |id| id.parse().unwrap());
  let context = Context::with_options(ContextOptions::new().domain_id(domain)).unwrap();
  let mut node = context
    .new_node(NodeName::new("/", "rust_peer").unwrap(), NodeOptions::new())
    .unwrap();
  smol::spawn(node.spinner().unwrap().spin()).detach();
  smol::block_on(within(TIMEOUT, &check, async {
    match check.as_str() {
      "graph" => graph(&mut node).await,
      "topics" => topics(&mut node).await,
      "services" => services(&mut node).await,
      "parameters" => parameters(&mut node).await,
      "foreign_convention" => foreign_convention(&mut node).await,
      other => panic!("no check '{other}'"),
    }
  }));
  println!("{check}: as it should be");
}
