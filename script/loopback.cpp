// Closes the one socket that ROS_HOSTNAME=localhost leaves open to the network. With it, a node in C++
// has its topics and services on the loopback interface, but its XML-RPC server on all addresses.
// Whoever reaches that server can have the topics sent to themselves by UDP, feed the node other
// topics, and shut it down. This library is loaded before ROS's libxmlrpcpp (LD_PRELOAD in script/env),
// and replaces the function that binds the server.
#include <arpa/inet.h>
#include <cstdlib>
#include <cstring>
#include <netinet/in.h>
#include <sys/socket.h>

static bool is_local(const char *name) {
  return !strcmp(name, "localhost") || !strncmp(name, "127.", 4) || !strcmp(name, "::1");
}

namespace XmlRpc {

class XmlRpcSocket {
  static bool bind(int fd, int port);
};

bool XmlRpcSocket::bind(int fd, int port) {
  const char *name = getenv("ROS_HOSTNAME");
  if (!name || !*name) name = getenv("ROS_IP");
  const bool local = name && is_local(name);
  int family = AF_INET;
  socklen_t length = sizeof(family);
  getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &family, &length);
  if (family == AF_INET6) {
    sockaddr_in6 address = {};
    address.sin6_family = AF_INET6;
    address.sin6_port = htons(port);
    address.sin6_addr = local ? in6addr_loopback : in6addr_any;
    return ::bind(fd, reinterpret_cast<sockaddr *>(&address), sizeof(address)) == 0;
  }
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(local ? INADDR_LOOPBACK : INADDR_ANY);
  return ::bind(fd, reinterpret_cast<sockaddr *>(&address), sizeof(address)) == 0;
}

}  // namespace XmlRpc
