#include "scene/internal/gltf_motion.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "scene/internal/imported_scene.h"
#include "scene/internal/mesh_file_check.h"
#include "scene/internal/obj_materials.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF's buffers are little-endian");

// glTF 2.0, section 3.6.2.2 (component types).
constexpr int kByte = 5120;
constexpr int kUnsignedByte = 5121;
constexpr int kShort = 5122;
constexpr int kUnsignedShort = 5123;
constexpr int kFloat = 5126;

std::vector<std::byte> FromBase64(std::string_view text) {
  std::vector<std::byte> bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    std::uint32_t value = 0;
    if (c >= 'A' && c <= 'Z') {
      value = static_cast<std::uint32_t>(c - 'A');
    } else if (c >= 'a' && c <= 'z') {
      value = static_cast<std::uint32_t>(c - 'a' + 26);
    } else if (c >= '0' && c <= '9') {
      value = static_cast<std::uint32_t>(c - '0' + 52);
    } else if (c == '+' || c == '/') {
      value = c == '+' ? 62 : 63;
    } else {
      break;  // The padding.
    }
    bits = bits << 6 | value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xffu));
  }
  return bytes;
}

// As the other JSON files of ours; glTF's own keys need fewer.
constexpr int kDeepestNesting = 64;

class MotionReader {
 public:
  explicit MotionReader(const std::filesystem::path& file) : file_(file) {
    const std::vector<std::byte> bytes = ReadWholeFile(file);
    std::span<const std::byte> text = bytes;
    if (bytes.size() >= 20 && NumberAt(bytes, 0) == 0x46546c67u) text = ReadChunks(bytes);
    const std::string_view characters(reinterpret_cast<const char*>(text.data()), text.size());
    if (JsonNesting(characters) > kDeepestNesting) {
      Refuse("document", "at most " + std::to_string(kDeepestNesting) + " levels of nesting");
    }
    document_ = json::parse(characters.begin(), characters.end(), nullptr, false);
  }

  void RequireSoundAccessors() const {
    if (!document_.is_object() || !document_.contains("accessors")) return;
    const json& accessors = document_["accessors"];
    const json& views = ListOf(document_, "bufferViews");
    for (std::size_t i = 0; accessors.is_array() && i < accessors.size(); ++i) {
      if (!accessors[i].is_object() || !accessors[i].contains("sparse")) continue;
      const json& sparse = accessors[i]["sparse"];
      const std::string where = "accessors[" + std::to_string(i) + "].sparse";
      for (const char* part : {"indices", "values"}) {
        if (!sparse.is_object() || !sparse.contains(part) || !sparse[part].is_object()) {
          Refuse(where, "an object with indices and values");
        }
        Index(sparse[part], "bufferView", views.size(), where + "." + part);
      }
    }
  }

  // A doubled child would be read twice, with all that is below it: 30 nodes make 2^30.
  void RequireTrees() const {
    if (!document_.is_object()) return;
    const json& nodes = ListOf(document_, "nodes");
    const json& scenes = ListOf(document_, "scenes");
    if (scenes.empty()) return;
    const json& scene = scenes[Index(document_, "scene", scenes.size(), "document", 0)];
    if (!scene.is_object()) Refuse("scenes", "objects");
    std::vector<int> level = Indices(scene, "nodes", nodes.size(), "scenes");
    std::vector<bool> seen(nodes.size());
    for (int depth = 0; !level.empty(); ++depth) {
      std::vector<int> below;
      for (const int node : level) {
        const auto i = static_cast<std::size_t>(node);
        if (seen[i]) Refuse(NodeKey(i), "one parent at most");
        // Below the root that assimp puts above several.
        if (depth >= kMostNodeLevels - 1) {
          Refuse(NodeKey(i), "at most " + std::to_string(kMostNodeLevels - 1) + " levels of nodes");
        }
        seen[i] = true;
        if (!nodes[i].is_object()) Refuse(NodeKey(i), "an object");
        const std::vector<int> children = Indices(nodes[i], "children", nodes.size(), NodeKey(i));
        below.insert(below.end(), children.begin(), children.end());
      }
      level = std::move(below);
    }
  }

  GltfMotion Read() {
    if (!document_.is_object()) Refuse("document", "a JSON object");
    GltfMotion motion;
    const json& nodes = ListOf(document_, "nodes");
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      motion.nodes.push_back(ReadNode(nodes[i], NodeKey(i)));
      motion.children.push_back(Indices(nodes[i], "children", nodes.size(), NodeKey(i)));
    }
    const json& scenes = ListOf(document_, "scenes");
    const std::size_t scene = Index(document_, "scene", scenes.size(), "document", 0);
    motion.roots = Indices(scenes[scene], "nodes", nodes.size(), "scenes");
    const json& animations = ListOf(document_, "animations");
    if (animations.size() > 1) {
      motion.notes.push_back(std::to_string(animations.size()) +
                             " animations, the first one is played");
    }
    if (!animations.empty()) ReadAnimation(animations[0], motion);
    return motion;
  }

 private:
  [[noreturn]] void Refuse(const std::string& key, const std::string& expected) const {
    throw std::runtime_error(file_.string() + ": " + key + ": expected " + expected);
  }

  static std::string NodeKey(std::size_t i) { return "nodes[" + std::to_string(i) + "]"; }

  static std::uint32_t NumberAt(std::span<const std::byte> bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof(value));
    return value;
  }

  // The JSON chunk of a .glb; its binary one is kept.
  std::span<const std::byte> ReadChunks(std::span<const std::byte> bytes) {
    std::span<const std::byte> text;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
      const std::size_t length = NumberAt(bytes, at);
      const std::uint32_t type = NumberAt(bytes, at + 4);
      if (length > bytes.size() - at - 8) Refuse("chunk", "no more bytes than the file has");
      const std::span<const std::byte> chunk = bytes.subspan(at + 8, length);
      if (type == 0x4e4f534au) text = chunk;
      if (type == 0x004e4942u) binary_.assign(chunk.begin(), chunk.end());
      at += 8 + length;
    }
    return text;
  }

  const json& ListOf(const json& owner, const char* key) const {
    static const json none = json::array();
    const auto found = owner.find(key);
    if (found == owner.end()) return none;
    if (!found->is_array()) Refuse(key, "a list");
    return *found;
  }

  std::size_t Index(const json& owner,
                    const char* key,
                    std::size_t count,
                    const std::string& where,
                    std::int64_t missing = -1) const {
    const auto found = owner.find(key);
    std::int64_t index = missing;
    if (found != owner.end()) index = found->is_number_integer() ? found->get<std::int64_t>() : -1;
    if (index < 0 || index >= static_cast<std::int64_t>(count)) {
      Refuse(where + "." + key, "a whole number below " + std::to_string(count));
    }
    return static_cast<std::size_t>(index);
  }

  std::vector<int> Indices(const json& owner,
                           const char* key,
                           std::size_t count,
                           const std::string& where) const {
    std::vector<int> indices;
    for (const json& entry : ListOf(owner, key)) {
      const std::int64_t index = entry.is_number_integer() ? entry.get<std::int64_t>() : -1;
      if (index < 0 || index >= static_cast<std::int64_t>(count)) {
        Refuse(where + "." + key, "whole numbers below " + std::to_string(count));
      }
      indices.push_back(static_cast<int>(index));
    }
    return indices;
  }

  std::vector<double> Numbers(const json& owner,
                              const char* key,
                              std::vector<double> missing,
                              const std::string& where) const {
    const auto found = owner.find(key);
    if (found == owner.end()) return missing;
    std::vector<double> numbers;
    if (found->is_array()) {
      for (const json& entry : *found) {
        numbers.push_back(entry.is_number() ? entry.get<double>() : NAN);
      }
    }
    const bool finite =
        std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
    if (numbers.size() != missing.size() || !finite) {
      Refuse(where + "." + key, std::to_string(missing.size()) + " numbers");
    }
    return numbers;
  }

  MovingNode ReadNode(const json& at, const std::string& where) const {
    if (!at.is_object()) Refuse(where, "an object");
    MovingNode node;
    const auto t = Numbers(at, "translation", {0.0, 0.0, 0.0}, where);
    const auto r = Numbers(at, "rotation", {0.0, 0.0, 0.0, 1.0}, where);
    const auto s = Numbers(at, "scale", {1.0, 1.0, 1.0}, where);
    node.translation = {t[0], t[1], t[2]};
    node.rotation = glm::normalize(glm::dquat(r[3], r[0], r[1], r[2]));
    node.scale = {s[0], s[1], s[2]};
    node.rest = glm::translate(glm::dmat4(1.0), node.translation) * glm::mat4_cast(node.rotation) *
                glm::scale(glm::dmat4(1.0), node.scale);
    const auto m = Numbers(at, "matrix", std::vector<double>(16, 0.0), where);
    if (at.contains("matrix")) {
      for (int i = 0; i < 16; ++i) node.rest[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
    }
    return node;
  }

  std::span<const std::byte> Buffer(std::size_t index) {
    const auto known = buffers_.find(index);
    if (known != buffers_.end()) return known->second;
    const json& buffer = ListOf(document_, "buffers")[index];
    const std::string where = "buffers[" + std::to_string(index) + "]";
    const auto uri = buffer.is_object() ? buffer.find("uri") : buffer.end();
    if (!buffer.is_object() || uri == buffer.end()) {
      if (index != 0 || binary_.empty()) Refuse(where + ".uri", "the place of its bytes");
      return buffers_[index] = binary_;
    }
    if (!uri->is_string()) Refuse(where + ".uri", "text");
    const std::string text = uri->get<std::string>();
    if (text.starts_with("data:")) {
      const std::size_t comma = text.find(',');
      if (comma == std::string::npos) Refuse(where + ".uri", "base64 data");
      return buffers_[index] = FromBase64(std::string_view(text).substr(comma + 1));
    }
    const std::filesystem::path path = file_.parent_path() / text;
    if (!IsInside(path, file_.parent_path())) Refuse(where + ".uri", "a file in the same folder");
    return buffers_[index] = ReadWholeFile(path);
  }

  // All elements of an accessor, one after the other.
  std::vector<double> Accessor(std::size_t index, std::string_view type, int components) {
    const json& accessor = ListOf(document_, "accessors")[index];
    const std::string where = "accessors[" + std::to_string(index) + "]";
    if (accessor.value("type", "") != type) Refuse(where + ".type", std::string(type));
    if (accessor.contains("sparse")) Refuse(where, "one that is not sparse");
    const json& views = ListOf(document_, "bufferViews");
    const json& view = views[Index(accessor, "bufferView", views.size(), where)];
    const std::span<const std::byte> bytes =
        Buffer(Index(view, "buffer", ListOf(document_, "buffers").size(), "bufferViews"));
    const int component_type = accessor.value("componentType", 0);
    const std::size_t size = component_type == kFloat                                       ? 4
                             : component_type == kShort || component_type == kUnsignedShort ? 2
                             : component_type == kByte || component_type == kUnsignedByte   ? 1
                                                                                            : 0;
    if (size == 0) Refuse(where + ".componentType", "5120 to 5123 or 5126");
    const auto count = accessor.value("count", std::int64_t{0});
    const auto element = size * static_cast<std::size_t>(components);
    const auto start =
        view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
    const auto stride = view.value("byteStride", element);
    constexpr std::int64_t kMostKeys = std::int64_t{1} << 24;
    if (count < 1 || count > kMostKeys || stride < element || start > bytes.size() ||
        (static_cast<std::size_t>(count) - 1) * stride + element > bytes.size() - start) {
      Refuse(where, "elements within its buffer");
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      for (int c = 0; c < components; ++c) {
        const std::byte* at =
            bytes.data() + start + i * stride + static_cast<std::size_t>(c) * size;
        values.push_back(Component(at, component_type));
        if (!std::isfinite(values.back())) Refuse(where, "finite numbers");
      }
    }
    return values;
  }

  // Whole numbers are normalised ones (section 3.11).
  static double Component(const std::byte* at, int type) {
    const auto read = [&](auto value) {
      std::memcpy(&value, at, sizeof(value));
      return static_cast<double>(value);
    };
    switch (type) {
      case kByte:
        return std::max(read(std::int8_t{}) / 127.0, -1.0);
      case kUnsignedByte:
        return read(std::uint8_t{}) / 255.0;
      case kShort:
        return std::max(read(std::int16_t{}) / 32767.0, -1.0);
      case kUnsignedShort:
        return read(std::uint16_t{}) / 65535.0;
      default:
        return read(float{});
    }
  }

  KeyTrack ReadTrack(const json& sampler, const std::string& path, const std::string& where) {
    const std::size_t count = ListOf(document_, "accessors").size();
    KeyTrack track;
    track.times_s = Accessor(Index(sampler, "input", count, where), "SCALAR", 1);
    if (!std::is_sorted(track.times_s.begin(), track.times_s.end(), std::less_equal<>())) {
      Refuse(where + ".input", "ascending times");
    }
    const std::string interpolation = sampler.value("interpolation", "LINEAR");
    if (interpolation == "STEP") {
      track.interpolation = KeyTrack::Interpolation::kStep;
    } else if (interpolation == "CUBICSPLINE") {
      track.interpolation = KeyTrack::Interpolation::kCubicSpline;
    } else if (interpolation != "LINEAR") {
      Refuse(where + ".interpolation", "STEP, LINEAR or CUBICSPLINE");
    }
    const bool turns = path == "rotation";
    const int components = turns ? 4 : 3;
    const std::vector<double> numbers =
        Accessor(Index(sampler, "output", count, where), turns ? "VEC4" : "VEC3", components);
    for (std::size_t i = 0; i < numbers.size(); i += static_cast<std::size_t>(components)) {
      track.values.emplace_back(
          numbers[i], numbers[i + 1], numbers[i + 2], turns ? numbers[i + 3] : 0.0);
    }
    const std::size_t a_key = track.interpolation == KeyTrack::Interpolation::kCubicSpline ? 3 : 1;
    if (track.values.size() != a_key * track.times_s.size()) {
      Refuse(where + ".output", std::to_string(a_key) + " values for each time");
    }
    for (std::size_t i = a_key / 2; turns && i < track.values.size(); i += a_key) {
      if (!(glm::length(track.values[i]) > 0.0)) Refuse(where + ".output", "unit quaternions");
    }
    return track;
  }

  void ReadAnimation(const json& animation, GltfMotion& motion) {
    const json& samplers = ListOf(animation, "samplers");
    for (const json& channel : ListOf(animation, "channels")) {
      const auto target = channel.find("target");
      if (target == channel.end() || !target->is_object()) {
        Refuse("animations[0].channels", "objects with a target");
      }
      if (!target->contains("node")) continue;  // As the specification has it.
      const std::string path = target->value("path", "");
      MovingNode& node =
          motion.nodes[Index(*target, "node", motion.nodes.size(), "animations[0].channels")];
      if (path == "weights") {
        motion.notes.emplace_back("animation of morph targets left out");
        continue;
      }
      auto* track = path == "translation" ? &node.translation_track
                    : path == "rotation"  ? &node.rotation_track
                    : path == "scale"     ? &node.scale_track
                                          : nullptr;
      if (track == nullptr) {
        Refuse("animations[0].channels.target.path", "translation, rotation, scale or weights");
      }
      const std::size_t sampler =
          Index(channel, "sampler", samplers.size(), "animations[0].channels");
      *track = ReadTrack(
          samplers[sampler], path, "animations[0].samplers[" + std::to_string(sampler) + "]");
      motion.duration_s = std::max(motion.duration_s, (*track)->times_s.back());
    }
    // A pose and no motion: keys at time 0 alone.
    constexpr double kAnyDurationS = 1.0;
    if (motion.duration_s <= 0.0) motion.duration_s = kAnyDurationS;
  }

  const std::filesystem::path& file_;
  json document_;
  std::vector<std::byte> binary_;
  std::map<std::size_t, std::vector<std::byte>> buffers_;
};

}  // namespace

void RequireSoundGltf(const std::filesystem::path& file) {
  const MotionReader reader(file);
  reader.RequireSoundAccessors();
  reader.RequireTrees();
}

GltfMotion ReadGltfMotion(const std::filesystem::path& file) {
  try {
    return MotionReader(file).Read();
  } catch (const json::exception& error) {
    throw std::runtime_error(file.string() + ": not a readable glTF file (" + error.what() + ")");
  }
}

}  // namespace pleinair
