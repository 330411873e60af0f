# MinGW on Linux compiles for Windows; what it builds needs none of its libraries.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_CXX_FLAGS_INIT -DMS_WIN64)  # which Python's headers know of Microsoft's compiler alone
set(CMAKE_MODULE_LINKER_FLAGS_INIT -static)
