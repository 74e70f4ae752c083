// Small glTF files for tests: a document, and numbers in its buffer.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "scene/image_io.h"
#include "scene/mesh.h"
#include "temporary_folder.h"

namespace pleinair {

class GltfFile {
 public:
  GltfFile() {
    document = {{"asset", {{"version", "2.0"}}},
                {"scene", 0},
                {"scenes", {{{"nodes", nlohmann::json::array({0})}}}},
                {"nodes", nlohmann::json::array()},
                {"meshes", nlohmann::json::array()},
                {"accessors", nlohmann::json::array()},
                {"bufferViews", nlohmann::json::array()}};
  }

  // `components` values an element; returns the accessor.
  int AddFloats(const std::vector<float>& values, int components) {
    static constexpr std::string_view kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const int view = AddBytes(values.data(), values.size() * sizeof(float));
    nlohmann::json accessor{{"bufferView", view},
                            {"componentType", 5126},
                            {"count", values.size() / static_cast<std::size_t>(components)},
                            {"type", kTypes[components]}};
    std::vector<float> lower(values.begin(), values.begin() + components);
    std::vector<float> upper = lower;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t c = i % static_cast<std::size_t>(components);
      lower[c] = std::min(lower[c], values[i]);
      upper[c] = std::max(upper[c], values[i]);
    }
    accessor["min"] = lower;
    accessor["max"] = upper;
    document["accessors"].push_back(accessor);
    return static_cast<int>(document["accessors"].size()) - 1;
  }

  int AddIndices(const std::vector<std::uint32_t>& values) {
    const int view = AddBytes(values.data(), values.size() * sizeof(std::uint32_t));
    document["accessors"].push_back({{"bufferView", view},
                                     {"componentType", 5125},
                                     {"count", values.size()},
                                     {"type", "SCALAR"}});
    return static_cast<int>(document["accessors"].size()) - 1;
  }

  // Returns the buffer view.
  int AddBytes(const void* data, std::size_t size) {
    while (buffer_.size() % 4 != 0) buffer_.push_back('\0');
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", size}});
    buffer_.append(static_cast<const char*>(data), size);
    return static_cast<int>(document["bufferViews"].size()) - 1;
  }

  // Adds `mesh` unchanged, in the file's own axes (+Y up), with its normals; returns its index.
  int AddMesh(const Mesh& mesh, int material = -1, const nlohmann::json& more_attributes = {}) {
    std::vector<float> positions;
    std::vector<float> normals;
    for (std::size_t v = 0; v < mesh.positions_m.size(); ++v) {
      for (int c = 0; c < 3; ++c) positions.push_back(mesh.positions_m[v][c]);
      for (int c = 0; c < 3; ++c) normals.push_back(mesh.normals[v][c]);
    }
    std::vector<std::uint32_t> indices;
    for (const glm::uvec3& triangle : mesh.triangles) {
      for (int c = 0; c < 3; ++c) indices.push_back(triangle[c]);
    }
    nlohmann::json attributes{{"POSITION", AddFloats(positions, 3)},
                              {"NORMAL", AddFloats(normals, 3)}};
    if (more_attributes.is_object()) attributes.update(more_attributes);
    nlohmann::json primitive{{"attributes", attributes}, {"indices", AddIndices(indices)}};
    if (material >= 0) primitive["material"] = material;
    document["meshes"].push_back({{"primitives", {primitive}}});
    return static_cast<int>(document["meshes"].size()) - 1;
  }

  // A channel of the only animation.
  void AddTrack(int node,
                const std::string& path,
                const std::vector<float>& times_s,
                const std::vector<float>& values,
                const std::string& interpolation = "LINEAR") {
    if (!document.contains("animations")) {
      document["animations"] = {
          {{"channels", nlohmann::json::array()}, {"samplers", nlohmann::json::array()}}};
    }
    nlohmann::json& animation = document["animations"][0];
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back({{"input", AddFloats(times_s, 1)},
                                     {"output", AddFloats(values, path == "rotation" ? 4 : 3)},
                                     {"interpolation", interpolation}});
  }

  // A .gltf, the buffer in it, or at `uri`.
  std::string Text(const std::string& uri = "") const {
    nlohmann::json whole = document;
    whole["buffers"] = {
        {{"byteLength", buffer_.size()},
         {"uri", uri.empty() ? "data:application/octet-stream;base64," + Base64() : uri}}};
    return whole.dump();
  }
  const std::string& Buffer() const { return buffer_; }

  // A .glb.
  std::string Binary() const {
    nlohmann::json whole = document;
    std::string data = buffer_;
    while (data.size() % 4 != 0) data.push_back('\0');
    whole["buffers"] = {{{"byteLength", data.size()}}};
    std::string text = whole.dump();
    while (text.size() % 4 != 0) text.push_back(' ');
    std::string file = "glTF";
    Append(file, 2);
    Append(file, 12 + 8 + text.size() + 8 + data.size());
    Append(file, text.size());
    file += "JSON" + text;
    Append(file, data.size());
    file += std::string("BIN\0", 4) + data;
    return file;
  }

  nlohmann::json document;

 private:
  static void Append(std::string& file, std::size_t number) {
    const auto value = static_cast<std::uint32_t>(number);
    char bytes[4];
    std::memcpy(bytes, &value, 4);
    file.append(bytes, 4);
  }

  std::string Base64() const {
    static constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < buffer_.size(); i += 3) {
      std::uint32_t bits = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        bits =
            bits << 8 | (i + j < buffer_.size() ? static_cast<unsigned char>(buffer_[i + j]) : 0);
      }
      for (std::size_t j = 0; j < 4; ++j) {
        text += i + j <= buffer_.size() ? kDigits[bits >> (18 - 6 * j) & 63u] : '=';
      }
    }
    return text;
  }

  std::string buffer_;
};

// A square of side 1 from the origin, x to the right and y up, seen from the front.
inline Mesh Square() {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

inline std::string PngOf(const Rgb8Image& image) {
  const TemporaryFolder folder;
  WritePng(folder / "texture.png", image);
  return ContentOf(folder / "texture.png");
}

}  // namespace pleinair
