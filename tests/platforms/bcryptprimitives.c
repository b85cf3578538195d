/* Windows has had `bcryptprimitives.dll` since Windows 7; Debian's wine 8 has not. Rust's
 * standard library takes its random seeds there. This stands in for it under wine. */

#include <windows.h>
#include <ntsecapi.h>

__declspec(dllexport) BOOL ProcessPrng(PBYTE bytes, SIZE_T size) {
    return RtlGenRandom(bytes, (ULONG)size);
}
