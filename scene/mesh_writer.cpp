#include "scene/mesh_writer.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scene/whole_file.h"

namespace pleinair {
namespace {

std::string NameInObj(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isspace(c) != 0; }, '_');
  return name.empty() ? "unnamed" : name;
}

std::string LibraryText(const Mesh& mesh) {
  std::string text;
  for (const Material& material : mesh.materials) {
    const glm::vec3& kd = material.diffuse_albedo;
    const glm::vec3& ks = material.specular_reflectance;
    text += fmt::format("newmtl {}\nKd {} {} {}\nKs {} {} {}\nPr {}\n",
                        NameInObj(material.name),
                        kd.x,
                        kd.y,
                        kd.z,
                        ks.x,
                        ks.y,
                        ks.z,
                        material.roughness);
  }
  return text;
}

}  // namespace

void WriteObj(const Mesh& mesh, const std::filesystem::path& file) {
  if (mesh.Empty()) throw std::invalid_argument("mesh: expected at least one triangle");
  const std::filesystem::path library = std::filesystem::path(file).replace_extension(".mtl");
  std::string text =
      fmt::format("# metres, +X east, +Y north, +Z up\nmtllib {}\n", library.filename().string());
  // The shortest text that reads back as the same float.
  for (const glm::vec3& p : mesh.positions_m) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const glm::vec3& n : mesh.normals) text += fmt::format("vn {} {} {}\n", n.x, n.y, n.z);
  std::vector<std::size_t> order(mesh.triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return mesh.triangle_group[a] < mesh.triangle_group[b];
  });
  std::size_t last = mesh.triangles.size();
  for (const std::size_t i : order) {
    const bool is_first = last == mesh.triangles.size();
    if (is_first || mesh.triangle_group[i] != mesh.triangle_group[last]) {
      text += "g " + NameInObj(mesh.group_names[mesh.triangle_group[i]]) + "\n";
    }
    if (is_first || mesh.triangle_material[i] != mesh.triangle_material[last]) {
      text += "usemtl " + NameInObj(mesh.materials[mesh.triangle_material[i]].name) + "\n";
    }
    const glm::uvec3 corner = mesh.triangles[i] + 1u;
    text += fmt::format("f {0}//{0} {1}//{1} {2}//{2}\n", corner.x, corner.y, corner.z);
    last = i;
  }
  WriteWholeText(library, LibraryText(mesh));
  WriteWholeText(file, text);
}

}  // namespace pleinair
