// Read a field of any of the graph's clouds: value<uint32_t>(cloud, "track_id", row).
#include <cstring>
#include <stdexcept>
#include <string>
#include <sensor_msgs/msg/point_cloud2.hpp>

template <typename T>
T value(
  const sensor_msgs::msg::PointCloud2 & cloud, const std::string & name, size_t row,
  size_t index = 0)
{
  for (const auto & field : cloud.fields) {
    if (field.name == name && row < cloud.width && index < field.count) {
      T result;
      std::memcpy(
        &result, &cloud.data.at(row * cloud.point_step + field.offset + index * sizeof(T)),
        sizeof(T));
      return result;
    }
  }
  throw std::out_of_range(name);
}
