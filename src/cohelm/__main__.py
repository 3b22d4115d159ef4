"""``python -m cohelm``: the command line."""

from cohelm.cli import main

if __name__ == "__main__":
    main()
