#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace voxatlas {

/// One JSON object for machines to read, built name by name and printed in one line.
/// The library that writes it (nlohmann's) stays inside the .cpp: its header costs seconds.
class JsonObject {
 public:
  JsonObject();
  ~JsonObject();
  JsonObject(JsonObject&&) noexcept;
  JsonObject& operator=(JsonObject&&) noexcept;

  JsonObject& add(std::string_view name, double value);
  JsonObject& add(std::string_view name, std::int64_t value);
  JsonObject& add(std::string_view name, const std::string& value);
  JsonObject& add(std::string_view name, const JsonObject& value);

  std::string text() const;

 private:
  struct Object;
  std::unique_ptr<Object> object_;
};

}  // namespace voxatlas
