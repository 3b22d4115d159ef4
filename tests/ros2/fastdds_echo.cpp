// A third peer: sends back Twist and LaserScan over Debian's Fast DDS, decoded and encoded again.
//
//     g++ -std=c++17 fastdds_echo.cpp -lfastrtps -lfastcdr -o echo && ./echo DOMAIN
//
// /twist goes to /echo/twist, /laserscan to /echo/laserscan; it ends when its stdin is closed.

#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

struct Twist {
  static constexpr const char* name = "geometry_msgs::msg::dds_::Twist_";
  std::array<double, 6> speeds{};  // linear x, y, z; angular x, y, z

  template <class Each> void visit(Each each) { each(speeds); }
};

struct LaserScan {
  static constexpr const char* name = "sensor_msgs::msg::dds_::LaserScan_";
  int32_t seconds = 0;
  uint32_t nanoseconds = 0;
  std::string frame;
  std::array<float, 7> numbers{};  // angles, increments, times and range limits
  std::vector<float> ranges, intensities;

  template <class Each> void visit(Each each) {
    each(seconds), each(nanoseconds), each(frame), each(numbers), each(ranges), each(intensities);
  }
};

// CDR of a message with a method `visit`; ROS 2 types have no key.
template <class Message> class Type : public fast::TopicDataType {
 public:
  Type() {
    setName(Message::name);
    m_typeSize = 1 << 20;
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    payload->encapsulation = CDR_LE;
    cdr.serialize_encapsulation();
    static_cast<Message*>(data)->visit([&](auto& field) { cdr << field; });
    payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    static_cast<Message*>(data)->visit([&](auto& field) { cdr >> field; });
    return true;
  }

  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [this] { return m_typeSize; };
  }
  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

template <class Message> class Echo : public fast::DataReaderListener {
 public:
  Echo(fast::DomainParticipant* participant, const std::string& topic) {
    fast::TypeSupport type(new Type<Message>);
    type.register_type(participant);
    auto make = [&](const std::string& name) {
      return participant->create_topic(name, Message::name, fast::TOPIC_QOS_DEFAULT);
    };
    auto writing = fast::DATAWRITER_QOS_DEFAULT;
    auto reading = fast::DATAREADER_QOS_DEFAULT;
    writing.reliability().kind = reading.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    writing.history().depth = reading.history().depth = 100;
    writing.endpoint().history_memory_policy = reading.endpoint().history_memory_policy =
        rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    auto publisher = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    auto subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
    writer_ = publisher->create_datawriter(make("rt/echo/" + topic), writing);
    subscriber->create_datareader(make("rt/" + topic), reading, this);
  }

  void on_data_available(fast::DataReader* reader) override {
    Message message;
    fast::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) writer_->write(&message);
    }
  }

 private:
  fast::DataWriter* writer_ = nullptr;
};

// Loopback only, without multicast: others are found at the ports of participants 0 to 31.
fast::DomainParticipantQos on_loopback() {
  auto qos = fast::PARTICIPANT_QOS_DEFAULT;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  udp->maxInitialPeersRange = 32;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t peer;
  rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
  qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  return qos;
}

int main(int, char** arguments) {
  auto participant = fast::DomainParticipantFactory::get_instance()->create_participant(
      std::atoi(arguments[1]), on_loopback());
  if (participant == nullptr) return 1;
  Echo<Twist> twist(participant, "twist");
  Echo<LaserScan> scan(participant, "laserscan");
  std::string line;
  while (std::getline(std::cin, line)) {
  }
  std::_Exit(0);
}
