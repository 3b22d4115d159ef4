"""DDS participant that ROS 2 tools see as a node; see ``transport``.

Types of ROS 2 messages for DDS, made from their public definitions; no ROS is installed.

The bytes on the wire are CDR from ``rosbags``; Cyclone DDS only needs each type's name and
structure, so that other DDS vendors recognise it.
"""

from __future__ import annotations

import contextlib
import functools
import os
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import (
    DDSException,
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from cohelm.errors import PlatformError
from cohelm.ros2.cdr import encode, types_of
from cohelm.ros2.parameters import DdsParameters
from cohelm.ros2.transport import LATCHED, Reliability, deliver, quality_text

_BASE = {
    "bool": bool,
    "byte": types.uint8,
    "char": types.uint8,
    "int8": types.int8,
    "uint8": types.uint8,
    "int16": types.int16,
    "uint16": types.uint16,
    "int32": types.int32,
    "uint32": types.uint32,
    "int64": types.int64,
    "uint64": types.uint64,
    "float32": types.float32,
    "float64": types.float64,
    "string": str,
}
_TYPES: Any = types
"""Types of arrays are made here from elements that only exist at run time."""
_HEADER_SIZE = 4
"""Size of the CDR encapsulation header, bytes."""


class Sample(IdlStruct):
    """Sample that carries the serialised message; its type is that of the subclass."""

    cdr: bytes

    def __init__(self, cdr: bytes) -> None:
        self.cdr = cdr

    def serialize(self, *_: Any, **__: Any) -> bytes:
        """Return the message as it is sent."""
        return self.cdr

    @classmethod
    def deserialize(cls, data: bytes, *_: Any, **__: Any) -> Sample:
        """Keep the bytes: the reader decides about decoding."""
        return cls(bytes(data))

    @classmethod
    def deserialize_key(cls, *_: Any, **__: Any) -> Sample:
        """Return an empty sample: ROS topics have no keys, and the publisher has gone."""
        return cls(b"")


@functools.cache
def dds_type(name: str, distribution: str) -> type[Sample]:
    """Return the DDS type of a message type, as ``nav_msgs/msg/Path``.

    Raises:
        KeyError: The type is unknown.
    """
    struct = _struct(name, distribution)

    class Named(Sample, typename=struct.__idl_typename__):
        pass

    setattr(Named, "__idl__", struct.__idl__)  # noqa: B010  # its metaclass declares it
    return Named


@functools.cache
def _struct(name: str, distribution: str) -> type[IdlStruct]:
    package, _, type_ = name.split("/")
    _, fields = types_of(distribution).fielddefs[name]
    # An empty struct has one hidden octet in ROS 2, since IDL forbids empty structs.
    described = {field: _field(each, distribution) for field, each in fields} or {
        "structure_needs_at_least_one_member": types.uint8
    }
    return make_idl_struct(type_, f"{package}.msg.dds_.{type_}_", described, dataclassify=False)


def _field(description: Any, distribution: str) -> Any:
    kind, content = description
    match kind.name:
        case "BASE":
            return _BASE[content[0]]
        case "NAME":
            return _struct(content, distribution)
        case "ARRAY":
            return _TYPES.array[_field(content[0], distribution), content[1]]
        case _:
            return _TYPES.sequence[_field(content[0], distribution)]


_DISCOVERY = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_MAX_PUBLICATIONS = 1000
_BATCH = 64
"""Maximum number of messages taken at once."""
_FIRST_INDEX, _LAST_INDEX = 12, 31
"""Range of participant indices where multicast is not used."""
_POLL = 0.2
"""Maximum time between two looks at the end flag, s."""


class DdsNode:
    """Node with its own thread for subscriptions.

    Args:
        parameters: Network.
        name: Name of the node.

    Raises:
        PlatformError: The network interface does not exist, or the domain is in use otherwise.
    """

    def __init__(self, parameters: DdsParameters, name: str) -> None:
        self.name, self._distribution = name, parameters.distribution
        domain = parameters.domain
        if domain is None:
            domain = int(os.environ.get("ROS_DOMAIN_ID", "0"))
        with contextlib.suppress(DDSException):  # a second node in this process shares the domain
            _domain(domain, _configuration(parameters, domain))
        try:
            self._participant = DomainParticipant(domain, Qos(Policy.Userdata(b"enclave=/;")))
        except DDSException as cause:
            where = parameters.interface or "the default interface"
            raise PlatformError(f"no DDS participant on {where}: {cause.msg}") from None
        self._readers: list[tuple[DataReader[Any], str, Callable[[Any], None]]] = []
        self._writers: list[DataWriter[Any]] = []
        self._ends = threading.Event()
        self._lock = threading.Lock()
        self._announce = self._writer(
            "ros_discovery_info", _DISCOVERY, LATCHED, parameters.distribution
        )
        self._thread = threading.Thread(target=self._serve, name=f"dds-{name}", daemon=True)

    def subscribe(
        self, topic: str, type_: str, quality: Reliability, take: Callable[[Any], None]
    ) -> None:
        """See :meth:`~cohelm.ros2.transport.RosNode.subscribe`."""
        found: Topic[Any] = Topic(self._participant, "rt" + topic, dds_type(type_, "humble"))
        reader = DataReader(self._participant, found, _qos(quality))
        self._readers.append((reader, type_, take))

    def publisher(self, topic: str, type_: str, quality: Reliability) -> Callable[[Any], None]:
        """Return the function that publishes a message; it may be called from any thread."""
        writer = self._writer("rt" + topic, type_, quality)
        self._writers.append(writer)
        sample = dds_type(type_, "humble")

        def publish(message: Any) -> None:
            with self._lock:
                writer.write(sample(encode(message)))

        return publish

    def matched(self, topic: str) -> int:
        """Return the number of publishers that a subscription is connected with."""
        for reader, _, _ in self._readers:
            if reader.topic.name == "rt" + topic:
                return len(reader.get_matched_publications())
        return 0

    def subscribers(self, topic: str) -> int:
        """Return the number of subscriptions that a publisher is connected with."""
        return sum(
            len(writer.get_matched_subscriptions())
            for writer in self._writers
            if writer.topic.name == "rt" + topic
        )

    def published(self) -> dict[str, str]:
        """Return type and quality of service of each topic that others publish, by topic."""
        reader = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
        time.sleep(_POLL)
        out = {}
        own = {writer.guid for writer in self._writers}
        for sample in reader.take(_MAX_PUBLICATIONS):
            topic = getattr(sample, "topic_name", "")
            if topic.startswith("rt/") and sample.key not in own:
                reliable = sample.qos[Policy.Reliability] != Policy.Reliability.BestEffort
                kind = sample.type_name.replace("::dds_::", "/").replace("::", "/").rstrip("_")
                kept = sample.qos[Policy.Durability] != Policy.Durability.Volatile
                out[topic[2:]] = quality_text(kind, reliable=reliable, kept=kept)
        return out

    def start(self) -> None:
        """Start the thread, and announce the node to ``ros2 node list``."""
        self._announce_node()
        self._thread.start()

    def close(self) -> None:
        """End the thread; may be called twice."""
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join()
        self._readers.clear()
        self._writers.clear()

    def _writer(
        self, topic: str, type_: str, quality: Reliability, distribution: str = "humble"
    ) -> DataWriter[Any]:
        found: Topic[Any] = Topic(self._participant, topic, dds_type(type_, distribution))
        return DataWriter(self._participant, found, _qos(quality))

    def _serve(self) -> None:
        if not self._readers:  # a wait without conditions returns at once
            return
        waits = WaitSet(self._participant)
        mask = ViewState.Any | InstanceState.Any | SampleState.NotRead
        conditions = [ReadCondition(reader, mask) for reader, _, _ in self._readers]
        for condition in conditions:
            waits.attach(condition)
        while not self._ends.is_set():
            waits.wait(duration(seconds=_POLL))
            for reader, type_, take in self._readers:
                for sample in reader.take(_BATCH):
                    if isinstance(sample, Sample):  # else the publisher has gone
                        deliver(sample.cdr, type_, take)

    def _announce_node(self) -> None:
        """Publish the node's readers and writers as rmw does."""
        distribution = self._distribution
        types = types_of(distribution).types
        gid = types["rmw_dds_common/msg/Gid"]

        size = 24 if distribution == "humble" else 16

        def gid_of(entity: Any) -> Any:
            return gid(data=np.frombuffer(entity.guid.bytes.ljust(size, b"\0"), np.uint8))

        node = types["rmw_dds_common/msg/NodeEntitiesInfo"](
            node_namespace="/",
            node_name=self.name,
            reader_gid_seq=[gid_of(reader) for reader, _, _ in self._readers],
            writer_gid_seq=[gid_of(writer) for writer in self._writers],
        )
        info = types[_DISCOVERY](gid=gid_of(self._participant), node_entities_info_seq=[node])
        self._announce.write(dds_type(_DISCOVERY, distribution)(encode(info, distribution)))


def _qos(quality: Reliability) -> Qos:
    """Return the DDS policies, with the other ones as ROS 2 sets them."""
    reliability = (
        Policy.Reliability.Reliable(duration(milliseconds=100))
        if quality.reliable
        else Policy.Reliability.BestEffort
    )
    kept = Policy.History.KeepLast(quality.depth)
    common = reliability, kept, Policy.DataRepresentation(use_cdrv0_representation=True)
    if not quality.transient:
        return Qos(*common, Policy.Durability.Volatile)
    unlimited = -1
    # Without it late subscribers get the last message only, whatever the depth.
    late = Policy.DurabilityService(duration(), kept, unlimited, unlimited, unlimited)
    return Qos(*common, Policy.Durability.TransientLocal, late)


@functools.lru_cache(maxsize=8)
def _domain(number: int, configuration: str) -> Domain:
    """Domain of this process; kept for its life."""
    return Domain(number, configuration)


def _configuration(parameters: DdsParameters, domain: int) -> str:
    """Cyclone's configuration: ours, and then that of the environment.

    Fast DDS sends type objects that Cyclone cannot parse (cyclonedds#2333): match types by name.
    """
    interface, peers = parameters.interface, list(parameters.peers)
    general = (
        f'<Interfaces><NetworkInterface name="{interface}"/></Interfaces>' if interface else ""
    )
    if interface == "lo":  # it often cannot multicast: find the others by their ports
        general += "<AllowMulticast>false</AllowMulticast>"
        peers.append("127.0.0.1")
    listed = "".join(f'<Peer Address="{address}"/>' for address in peers)
    discovery = (
        f"<ParticipantIndex>{_free_index(domain)}</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>{listed}</Peers>"
    )
    ours = (
        "<CycloneDDS><Domain>"
        "<Compatibility><IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>"
        f"<General>{general}</General>{f'<Discovery>{discovery}</Discovery>' if listed else ''}"
        "</Domain></CycloneDDS>"
    )
    theirs = os.environ.get("CYCLONEDDS_URI", "")
    return f"{ours},{theirs}" if theirs else ours


def _free_index(domain: int) -> int:
    """Participant index whose ports nobody uses.

    Fast DDS shares its ports without an error, and then neither side gets its messages; it starts
    at index 0 and looks for others up to 31.
    """
    for index in range(_FIRST_INDEX, _LAST_INDEX):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("127.0.0.1", 7400 + 250 * domain + 10 + 2 * index))
            except OSError:
                continue
            return index
    raise PlatformError(f"no free port for another participant in domain {domain}")
