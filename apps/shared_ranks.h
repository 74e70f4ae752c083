// The ranks that this process shares its job with.
#pragma once

#include "relight/transport/rank_group.h"

namespace pleinair {

// Null where the process is alone: always in `pleinair`, never in `pleinair-mpi`.
RankGroup* SharedRanks();
// Called once, at the program's start; `ranks` outlives all use.
void SetSharedRanks(RankGroup* ranks);

}  // namespace pleinair
