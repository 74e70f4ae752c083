// The virtual objects of a site, written to its folder.
#pragma once

#include <filesystem>
#include <span>

#include "datasets/sequence.h"

namespace pleinair {

// Writes `objects` to the site's file of `folder` (see site_file.h; or `folder` is that file
// itself), in place of its own. Notes on an object stay with the object of the same mesh; of
// several with the one of the same pose.
//
// Throws  std::runtime_error, one line, as EditSiteFile; for a mesh that is not in the folder, a
//         pose that ReadSequence would refuse, two objects of one mesh and pose. Then nothing is
//         written.
void SaveObjects(const std::filesystem::path& folder, std::span<const VirtualObjectEntry> objects);

// Returns the path of `mesh` relative to `folder`. A file from outside is first copied to
// objects/NAME/, completely or not at all. Files that it names in its own folder or below are
// copied too: material libraries and their textures, buffers and images of a glTF. An identical
// copy is used again; for another file of that name the folder is objects/NAME-2/ and so on.
//
// Throws  std::runtime_error, one line, naming the file.
std::filesystem::path BringObjectFile(const std::filesystem::path& folder,
                                      const std::filesystem::path& mesh);

}  // namespace pleinair
