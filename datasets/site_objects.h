// The virtual objects of a site, written to its folder.
#pragma once

#include <filesystem>
#include <span>

#include "datasets/sequence.h"

namespace pleinair {

// Makes `objects` those that the site's file of `folder` names (see site_file.h; or `folder` is
// that file itself). None: it names none. Notes that it has on an object stay with the object of
// that mesh, of several with the one of that pose.
//
// Throws  std::runtime_error, one line, as EditSiteFile; for a mesh that is not in the folder, a
//         pose that ReadSequence would refuse, two objects of one mesh and pose. Then nothing is
//         written.
void SaveObjects(const std::filesystem::path& folder, std::span<const VirtualObjectEntry> objects);

// The path of `mesh` relative to `folder`. A file from outside is copied to objects/NAME/ first,
// with the files that it names in its own folder or below (material libraries and their textures,
// buffers and images of a glTF), completely or not at all. A copy that is there already, byte for
// byte, is used again; beside another file of that name it is objects/NAME-2/ and so on.
//
// Throws  std::runtime_error, one line, naming the file.
std::filesystem::path BringObjectFile(const std::filesystem::path& folder,
                                      const std::filesystem::path& mesh);

}  // namespace pleinair
