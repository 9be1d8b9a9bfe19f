# SPDX-License-Identifier: Apache-2.0

# Compiles for WebAssembly with Debian's clang, of the version $LLVM or 19, libc++ and WASI's C library.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
find_program(CMAKE_CXX_COMPILER NAMES clang++-$ENV{LLVM} clang++-19 REQUIRED)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
