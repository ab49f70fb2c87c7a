/* Names of macros that another denoiser library's public header defines, in the engine's way on purpose: as a mistake wherever they are used. */
#define NRD_INCLUDED a name of another library
#define NRD_API a name of another library
#define NRD_CALL a name of another library
#define NRD_VERSION_MAJOR a name of another library
#define NRD_VERSION_MINOR a name of another library
#define NRD_VERSION_BUILD a name of another library
#define NRD_VERSION_DATE a name of another library
