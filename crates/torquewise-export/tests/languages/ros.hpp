// Stand-in for the parts of ROS 2 that the node uses: declarations as in rclcpp and the message
// packages of Humble, so that a compiler can check the node where there is no ROS.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace std_msgs::msg {
struct Header {
  struct { std::int32_t sec; std::uint32_t nanosec; } stamp;
  std::string frame_id;
};
struct Bool { bool data = false; };
}

namespace sensor_msgs::msg {
struct JointState {
  using SharedPtr = std::shared_ptr<JointState>;
  std_msgs::msg::Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};
}

namespace std_msgs::msg {
struct Float64MultiArray { std::vector<double> data; };
}

namespace trajectory_msgs::msg {
struct JointTrajectoryPoint {
  using SharedPtr = std::shared_ptr<JointTrajectoryPoint>;
  std::vector<double> positions, velocities, accelerations, effort;
};
}

namespace rclcpp {
struct QoS { QoS(std::size_t) {} };
struct SensorDataQoS : QoS { SensorDataQoS() : QoS(5) {} };
struct Logger {};
struct Clock {};

template <typename Message> struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  void publish(const Message & message);
};

template <typename Message> struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
};

struct Node {
  explicit Node(const std::string & name);
  virtual ~Node() = default;
  template <typename Value> Value declare_parameter(const std::string & name, const Value & usual);
  template <typename Message> std::shared_ptr<Publisher<Message>> create_publisher(
    const std::string & topic, const QoS & qos);
  template <typename Message, typename Callback>
  std::shared_ptr<Subscription<Message>> create_subscription(
    const std::string &, const QoS &, Callback && callback)
  {
    std::function<void(typename Message::SharedPtr)> checked = callback;
    return nullptr;
  }
  Logger get_logger() const;
  std::shared_ptr<Clock> get_clock();
};

void init(int argc, char ** argv);
void spin(std::shared_ptr<Node> node);
void shutdown();
}

void logged(const rclcpp::Logger & logger, const char * format, ...)
  __attribute__((format(printf, 2, 3)));

#define RCLCPP_INFO(logger, ...) logged(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) logged(logger, __VA_ARGS__)
#define RCLCPP_ERROR_THROTTLE(logger, clock, period, ...) \
  do { (void)(clock); (void)(period); logged(logger, __VA_ARGS__); } while (0)
