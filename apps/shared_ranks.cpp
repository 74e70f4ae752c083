#include "apps/shared_ranks.h"

namespace pleinair {
namespace {

RankGroup* g_ranks = nullptr;

}  // namespace

RankGroup* SharedRanks() { return g_ranks; }

void SetSharedRanks(RankGroup* ranks) { g_ranks = ranks; }

}  // namespace pleinair
