// Finds everything wrong with a site that can be found before its light is estimated.
#pragma once

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "session/check/site_warning.h"

namespace pleinair {

// Checks mesh, camera, objects and survey map, and where the sequence has pictures their times,
// edges and shadows. Returns warnings only for contradictions: docs/site.md lists what each warning
// needs. Cost shadows 0.2 to 0.6 s for each frame; only a few frames are used. Throws as LoadMesh,
// ReadRadianceImage and MakeRecordedFrameSource. Frames that cannot be read are ignored.
SiteWarnings CheckSite(const Sequence& sequence, FrameKind frames);

}  // namespace pleinair
