// All that can be known to be wrong with a site before its light is estimated.
#pragma once

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "session/check/site_warning.h"

namespace pleinair {

// Looks at mesh, camera, objects and survey map, and where the sequence has pictures at their
// times, edges and shadows. Silent where nothing contradicts: see docs/site.md for what each
// warning needs to be seen. Cost    shadows 0.2 to 0.6 s a frame; of the frames a few are looked
// at. Throws  as LoadMesh, ReadRadianceImage and MakeRecordedFrameSource. Frames that cannot be
// read
//         are passed over.
SiteWarnings CheckSite(const Sequence& sequence, FrameKind frames);

}  // namespace pleinair
