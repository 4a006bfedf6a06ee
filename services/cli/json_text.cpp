#include "cli/json_text.hpp"

#include <nlohmann/json.hpp>

namespace voxatlas {

struct JsonObject::Object {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
};

JsonObject::JsonObject() : object_(std::make_unique<Object>()) {}
JsonObject::~JsonObject() = default;
JsonObject::JsonObject(JsonObject&&) noexcept = default;
JsonObject& JsonObject::operator=(JsonObject&&) noexcept = default;

JsonObject& JsonObject::add(std::string_view name, double value) {
  object_->json[std::string(name)] = value;
  return *this;
}

JsonObject& JsonObject::add(std::string_view name, std::int64_t value) {
  object_->json[std::string(name)] = value;
  return *this;
}

JsonObject& JsonObject::add(std::string_view name, const std::string& value) {
  object_->json[std::string(name)] = value;
  return *this;
}

JsonObject& JsonObject::add(std::string_view name, const JsonObject& value) {
  object_->json[std::string(name)] = value.object_->json;
  return *this;
}

std::string JsonObject::text() const {
  // Names of files and sources may hold any bytes: what is no UTF-8 is replaced, not thrown over.
  return object_->json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace voxatlas
