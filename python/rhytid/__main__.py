from ._command_line import main

main()
