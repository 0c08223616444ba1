// SPDX-License-Identifier: MIT
// What grpc.health.v1 says of a server.
#pragma once

#include <string>

namespace limn::e2e {

// "SERVING", "NOT_SERVING" or an error's message. address: HOST:PORT, without TLS.
std::string Health(const std::string& address, const std::string& service);

}  // namespace limn::e2e
