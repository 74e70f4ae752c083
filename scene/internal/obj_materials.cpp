#include "scene/internal/obj_materials.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "scene/trimmed.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// Takes the first word off `text`.
std::string_view TakeWord(std::string_view& text) {
  text = Trimmed(text);
  const std::string_view word = text.substr(0, text.find_first_of(" \t"));
  text.remove_prefix(word.size());
  return word;
}

struct Place {
  std::filesystem::path file;
  int line = 0;

  [[noreturn]] void Refuse(const std::string& why) const {
    throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + why);
  }
};

float Number(const Place& place, std::string_view key, std::string_view word) {
  std::string_view digits = word;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  float value = 0.0f;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc() || result.ptr != digits.data() + digits.size() ||
      !std::isfinite(value) || value < 0.0f) {
    place.Refuse(std::string(key) + " '" + std::string(word) + "': expected a finite number >= 0");
  }
  return value;
}

// An opacity is left out, so that a malformed one is no error.
float OpacityOr1(std::string_view rest) {
  const std::string_view word = rest.substr(rest.find_last_of(" \t") + 1);
  float value = 1.0f;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  return result.ec == std::errc() && value >= 0.0f ? std::min(value, 1.0f) : 1.0f;
}

// One value is used for all three.
glm::vec3 Colour(const Place& place, std::string_view key, std::string_view rest) {
  std::vector<float> values;
  for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
    values.push_back(Number(place, key, word));
  }
  if (values.size() == 1) return glm::vec3(values[0]);
  if (values.size() != 3) place.Refuse(std::string(key) + ": expected three numbers");
  return {values[0], values[1], values[2]};
}

// A library's data of one material; roughness follows when all of it is known.
struct Definition {
  std::string name;
  std::optional<glm::vec3> diffuse_albedo;  // Kd
  glm::vec3 specular_reflectance{0.0f};     // Ks
  std::optional<float> roughness;           // Pr
  std::optional<float> phong_exponent;      // Ns
  std::string diffuse_texture;              // map_Kd
  float opacity = 1.0f;                     // d
};

SourceMaterial Finish(const std::filesystem::path& library,
                      const Definition& definition,
                      TexturesByName& textures) {
  SourceMaterial material;
  material.name = definition.name;
  material.dielectric_reflectance = definition.specular_reflectance;
  material.opacity_left_out = definition.opacity;
  if (definition.diffuse_albedo) material.base_colour = *definition.diffuse_albedo;
  if (definition.roughness) {
    material.roughness = *definition.roughness;
  } else if (definition.phong_exponent) {
    // alpha = roughness^2 and alpha^2 = 2 / (Ns + 2).
    material.roughness = std::pow(2.0f / (*definition.phong_exponent + 2.0f), 0.25f);
  }
  if (!definition.diffuse_texture.empty()) {
    const std::filesystem::path image = library.parent_path() / definition.diffuse_texture;
    const auto [entry, is_new] = textures.try_emplace({image.string(), false});
    std::error_code error;
    if (is_new && IsInside(image, library.parent_path()) &&
        std::filesystem::is_regular_file(image, error) &&
        std::filesystem::file_size(image, error) > 0) {
      entry->second = DecodeTexture(ReadWholeFile(image), false);
    }
    material.texture = entry->second;
    if (material.texture) {
      // A texture alone is the albedo; with Kd, Kd scales it.
      if (!definition.diffuse_albedo) material.base_colour = glm::vec3(1.0f);
    } else {
      material.unreadable_texture = definition.diffuse_texture;
    }
  }
  return material;
}

void ReadLibrary(const std::filesystem::path& library, ObjMaterials& materials) {
  std::ifstream stream(library);
  if (!stream) throw std::runtime_error(library.string() + ": cannot be read");
  Place place{library, 0};
  std::optional<Definition> current;
  const auto finish = [&]() {
    if (!current) return;
    // A name defined twice: the first one counts, as for assimp.
    materials.by_name.emplace(current->name, Finish(library, *current, materials.textures));
  };
  for (std::string line; std::getline(stream, line);) {
    ++place.line;
    std::string_view rest = line;
    const std::string_view key = TakeWord(rest);
    rest = Trimmed(rest);
    if (key == "newmtl") {
      finish();
      current.emplace();
      current->name = std::string(rest);
      continue;
    }
    if (key == "d" && current) current->opacity = OpacityOr1(rest);
    const bool known = key == "Kd" || key == "Ks" || key == "Pr" || key == "Ns" || key == "map_Kd";
    if (!known) continue;
    if (!current) place.Refuse(std::string(key) + " before the first newmtl");
    if (key == "Kd") {
      current->diffuse_albedo = Colour(place, key, rest);
    } else if (key == "Ks") {
      current->specular_reflectance = Colour(place, key, rest);
    } else if (key == "Pr") {
      current->roughness = Number(place, key, rest);
      if (*current->roughness > 1.0f) place.Refuse("Pr '" + std::string(rest) + "': expected 0..1");
    } else if (key == "Ns") {
      current->phong_exponent = Number(place, key, rest);
    } else {
      // Options (-s 1 1 1 ...) stand before the name.
      current->diffuse_texture = std::string(rest.substr(rest.find_last_of(" \t") + 1));
    }
  }
  finish();
}

// The libraries of one mtllib line: one name with blanks in it, or several names.
std::vector<std::string> LibraryNames(const std::filesystem::path& folder, std::string_view rest) {
  std::error_code error;
  const std::string whole(Trimmed(rest));
  if (std::filesystem::is_regular_file(folder / whole, error)) return {whole};
  std::vector<std::string> names;
  for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
    names.emplace_back(word);
  }
  return names;
}

}  // namespace

bool IsInside(const std::filesystem::path& file, const std::filesystem::path& folder) {
  // An empty folder is the current one. The name that is appended and dropped again leaves a
  // trailing separator off.
  const std::filesystem::path base =
      std::filesystem::absolute(folder / "x").lexically_normal().parent_path();
  const std::filesystem::path relative =
      std::filesystem::absolute(file).lexically_normal().lexically_relative(base);
  return !relative.empty() && *relative.begin() != "..";
}

ObjMaterials ReadObjMaterials(const std::filesystem::path& obj) {
  ObjMaterials materials;
  std::ifstream stream(obj);
  if (!stream) throw std::runtime_error(obj.string() + ": cannot be read");
  Place place{obj, 0};
  const std::filesystem::path folder = obj.parent_path();
  for (std::string line; std::getline(stream, line);) {
    ++place.line;
    std::string_view rest = line;
    if (TakeWord(rest) != "mtllib") continue;
    for (const std::string& name : LibraryNames(folder, rest)) {
      const std::filesystem::path library = folder / name;
      if (!IsInside(library, folder)) {
        place.Refuse("mtllib '" + name + "': expected a file in the mesh's folder");
      }
      std::error_code error;
      if (std::filesystem::is_regular_file(library, error)) {
        ReadLibrary(library, materials);
        materials.libraries.push_back(name);
      } else {
        materials.missing_libraries.push_back(name);
      }
    }
  }
  return materials;
}

}  // namespace pleinair
