/* bcryptprimitives.dll, from which what is written in Rust takes random bytes; Wine 8 has none. */
#include <windows.h>

#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(BYTE* to, SIZE_T size) {
  return RtlGenRandom(to, (ULONG)size);
}
