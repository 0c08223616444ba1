// SPDX-License-Identifier: MIT
#include "server/server_info.h"

#include <string>

namespace limn {

v1::GetServerInfoResponse MakeServerInfo(const ServerLimits& limits, int threads) {
  v1::GetServerInfoResponse info;
  info.set_version(LIMN_VERSION);
  info.add_schemes(v1::SCHEME_DOO_SABIN);
  info.add_schemes(v1::SCHEME_CATMULL_CLARK);
  info.add_schemes(v1::SCHEME_LOOP);
  info.add_encodings(v1::MESH_ENCODING_PACKED);
  info.add_encodings(v1::MESH_ENCODING_DRACO);
  info.add_encodings(v1::MESH_ENCODING_DRACO_QUANTIZED);
  info.add_rpcs("Interpolate");
  info.add_rpcs("Batch");
  info.add_rpcs("Evaluate");
  info.add_rpcs("GetServerInfo");
  for (const LimitEntry& entry : LimitTable()) {
    v1::Limit* limit = info.add_limits();
    limit->set_name(std::string(entry.name));
    limit->set_value(limits.*entry.value);
    limit->set_unit(std::string(entry.unit));
    limit->set_description(std::string(entry.description));
  }
  info.set_threads(static_cast<std::uint32_t>(threads));
  return info;
}

}  // namespace limn
