// A C++ exception that leaves a function with C linkage.
#include <stdexcept>

extern "C" void throw_an_exception() { throw std::runtime_error("the pump throws"); }
