"""`python -m mjbiped` is the command `mjbiped`."""

from mjbiped.cli.main import main

if __name__ == "__main__":
    main()
