#include "apps/irradiance_file.h"

#include <cmath>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"

namespace pleinair {
namespace {

constexpr std::size_t kMostPoints = 1000000;
constexpr double kFarthestM = 1e6;

std::vector<glm::vec3> ReadVectors(const JsonCursor& list, double limit) {
  std::vector<glm::vec3> vectors;
  for (const JsonCursor& entry : list.List(1, kMostPoints)) {
    glm::vec3 vector;
    glm::length_t axis = 0;
    for (const JsonCursor& value : entry.List(3, 3)) {
      vector[axis++] = static_cast<float>(value.NumberIn(-limit, limit));
    }
    vectors.push_back(vector);
  }
  return vectors;
}

std::vector<glm::vec3> ReadNormals(const JsonCursor& list) {
  std::vector<glm::vec3> normals = ReadVectors(list, 2.0);
  const std::vector<JsonCursor> entries = list.List(1, kMostPoints);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const float length = glm::length(normals[i]);
    if (!(std::abs(length - 1.0f) <= 1e-3f)) entries[i].Fail("a unit vector");
    normals[i] /= length;
  }
  return normals;
}

std::string_view NameOf(LightPart part) {
  switch (part) {
    case LightPart::kDirect:
      return "direct";
    case LightPart::kIndirect:
      return "indirect";
    case LightPart::kTotal:
      break;
  }
  return "total";
}

// Numbers are written in the fewest digits that give the same float back.
class Text {
 public:
  void Add(const glm::vec3& rgb) {
    fmt::format_to(std::back_inserter(text_), "[{},{},{}]", rgb.x, rgb.y, rgb.z);
  }
  void Add(std::string_view text) { text_ += text; }
  // "[a,b,...]" of `count` entries that write(i) adds.
  template <class Write>
  void AddList(std::size_t count, const Write& write) {
    text_ += '[';
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0) text_ += ',';
      write(i);
    }
    text_ += ']';
  }
  void AddVectors(std::span<const glm::vec3> vectors) {
    AddList(vectors.size(), [&](std::size_t i) { Add(vectors[i]); });
  }

  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

constexpr std::string_view kWorld =
    "ENU metres: +X east, +Y north, +Z up; azimuths clockwise from north";

void AddHeading(const IrradianceHeading& heading, const PointsFile& points, Text& text) {
  const nlohmann::json bounces =
      heading.bounces == kAllBounces ? nlohmann::json("all") : nlohmann::json(heading.bounces);
  const RadiositySummary& radiosity = heading.radiosity;
  const nlohmann::json summary = {{"patches", radiosity.patches},
                                  {"exposed_faces", radiosity.exposed_faces},
                                  {"iterations", radiosity.iterations},
                                  {"residual", radiosity.residual},
                                  {"energy_error", radiosity.energy_error}};
  text.Add(
      fmt::format("{{\n\"world\": \"{}\",\n\"light\": {},\n\"part\": \"{}\",\n"
                  "\"bounces\": {},\n\"radiosity\": {},\n\"points\": ",
                  kWorld,
                  heading.light_json,
                  NameOf(heading.part),
                  bounces.dump(),
                  summary.dump()));
  text.AddVectors(points.points_m);
  text.Add(",\n\"normals\": ");
  text.AddVectors(points.normals);
}

}  // namespace

PointsFile ReadPointsFile(const std::filesystem::path& file, bool needs_normals) {
  const nlohmann::json json = LoadJson(file);
  const JsonCursor document(json, file.string());
  document.CheckKeys({"points", "normals"});
  PointsFile points;
  points.points_m = ReadVectors(document.Required("points"), kFarthestM);
  if (needs_normals) {
    points.normals = ReadNormals(document.Required("normals"));
  } else if (const auto normals = document.Optional("normals")) {
    points.normals = ReadNormals(*normals);
  }
  return points;
}

std::string IrradianceText(const IrradianceHeading& heading,
                           const PointsFile& points,
                           std::span<const glm::vec3> irradiance,
                           std::size_t lights) {
  Text text;
  AddHeading(heading, points, text);
  text.Add(",\n\"layout\": \"irradiance[point][normal][region][rgb]\",\n\"irradiance\": ");
  const std::size_t normals = points.normals.size();
  text.AddList(points.points_m.size(), [&](std::size_t p) {
    text.Add("\n");
    text.AddList(normals, [&](std::size_t n) {
      text.AddVectors(irradiance.subspan((p * normals + n) * lights, lights));
    });
  });
  text.Add("\n}\n");
  return text.Take();
}

std::string CoefficientsText(const IrradianceHeading& heading,
                             const PointsFile& points,
                             std::span<const ShRgb> coefficients,
                             std::size_t lights) {
  Text text;
  AddHeading(heading, points, text);
  text.Add(
      ",\n\"layout\": \"coefficients[point][region][9][rgb] of incident radiance, orthonormal real "
      "basis, (l, m) = (0,0), (1,-1), (1,0), (1,1), (2,-2), ...; Y(1,-1) ~ y, Y(1,0) ~ z, Y(1,1) ~ "
      "x\",\n\"coefficients\": ");
  text.AddList(points.points_m.size(), [&](std::size_t p) {
    text.Add("\n");
    text.AddList(lights,
                 [&](std::size_t light) { text.AddVectors(coefficients[p * lights + light]); });
  });
  text.Add("\n}\n");
  return text.Take();
}

}  // namespace pleinair
